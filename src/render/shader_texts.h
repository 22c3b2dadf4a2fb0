#pragma once

#include <string_view>

// The files of shaders/, as the build embeds them (embed_shaders.cmake). A variable is named as its file, dots as
// underscores.
namespace tellurion::render::shaders {

extern const std::string_view constants;
extern const std::string_view frame_block;
extern const std::string_view lighting;
extern const std::string_view layers;
extern const std::string_view blocks;
extern const std::string_view blocks_software;
extern const std::string_view one_block;
extern const std::string_view exact_light;
extern const std::string_view exact_light_software;
extern const std::string_view ground;
extern const std::string_view air_structs;
extern const std::string_view air_block;
extern const std::string_view air_model;
extern const std::string_view air_ray;
extern const std::string_view air;
extern const std::string_view air_view_comp;
extern const std::string_view sky_vert;
extern const std::string_view sky_frag;
extern const std::string_view no_air;
extern const std::string_view behind_air;
extern const std::string_view star_vert;
extern const std::string_view star_frag;
extern const std::string_view disc_vert;
extern const std::string_view disc_frag;
extern const std::string_view terrain_vert;
extern const std::string_view terrain_frag;
extern const std::string_view terrain_layers_frag;
extern const std::string_view warp_direction;
extern const std::string_view warp_vert;
extern const std::string_view warp_frag;
extern const std::string_view debug_tiles_frag;
extern const std::string_view debug_lines_vert;
extern const std::string_view debug_lines_frag;

}  // namespace tellurion::render::shaders
