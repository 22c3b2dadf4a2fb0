// What is the same for a whole frame with air: filled by air_pass.cpp (struct AirBlock).
layout(std140, binding = 1) uniform AirBlock {
  AirModel air;
  AirView airView;
};
