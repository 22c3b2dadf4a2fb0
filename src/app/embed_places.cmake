# Writes one C++ file with the lists of places: cmake -DOUTPUT=FILE -DFOLDER=DIR -DNAMES=earth,mars -P embed_places.cmake
set(text "#include \"app/shipped_places.h\"\n\nnamespace tellurion::app {\n\nstd::string_view shippedPlaces(std::string_view body) {\n")
string(REPLACE "," ";" names "${NAMES}")
foreach(name IN LISTS names)
  file(READ "${FOLDER}/${name}.csv" content)
  string(APPEND text "  if (body == \"${name}\") return R\"csv(${content})csv\";\n")
endforeach()
string(APPEND text "  return {};\n}\n\n}  // namespace tellurion::app\n")
file(WRITE "${OUTPUT}" "${text}")
