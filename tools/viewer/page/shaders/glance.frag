#version 300 es
// Finds whether the surface at some pixels of a picture was photographed, as tools/picture/photographed_share.cpp does.
#include "../../../../blend/shaders/picture.glsl"
#include "../../../../blend/shaders/surface_texel.glsl"
#include "../../../../blend/shaders/tables.glsl"
#include "pixel_in_world.glsl"

uniform usampler2D surfaces;
uniform vec4 part;           // the part of the picture, first row below: its beginning, pixels a step
uniform float least_cosine;  // between the directions to the two cameras
uniform float enlargement;   // how many times as far the stored one may be

layout(location = 0) out vec4 photographed;

bool is_photographed(uvec2 range, vec3 world) {
  vec3 to_novel = center.xyz - world;
  float o = length(to_novel);
  for (uint i = range.x; i < range.y; ++i) {
    uint view = entry(references, i).x & 0x0FFFFFFFu;
    if (!(view_texel(view, 4u).x > 0.0)) continue;  // one that the page does not know yet
    vec3 to_stored = view_texel(view, 3u).xyz - world;
    float stored = length(to_stored);
    if (stored < enlargement * o && dot(to_novel, to_stored) > least_cosine * o * stored) return true;
  }
  return false;
}

void main() {
  vec2 at = floor(part.xy + part.zw * gl_FragCoord.xy) + 0.5;
  uvec4 texel = texelFetch(surfaces, clamp(ivec2(at), ivec2(0), textureSize(surfaces, 0) - 1), 0);
  bool seen = texel.x != kNothing;
  uvec2 range = seen ? entry(cells, entry(zones, texel.x).z).xy : uvec2(0);
  photographed = vec4(seen && is_photographed(range, world_of(at, uintBitsToFloat(texel.y))) ? 1.0 : 0.0);
}
