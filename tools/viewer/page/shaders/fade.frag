#version 300 es
// Averaged colours, to be laid over a picture where no photograph that is valid was taken from near there: as opaque as
// the best of them is off in direction.
#include "../../../../blend/shaders/picture.glsl"
#include "../../../../blend/shaders/surface_texel.glsl"
#include "../../../../blend/shaders/srgb.glsl"
#include "../../../../blend/shaders/tables.glsl"

#define SAMPLES_ACROSS 1.0
#include "../../../../blend/shaders/photographs.glsl"
#include "pixel_in_world.glsl"

uniform usampler2D surfaces;
uniform float least_cosine;  // between the directions to the two cameras, from which on a photograph is all that is shown

layout(location = 0) out vec4 color;

// In [0, 1]; most pixels are done with the first view.
float nearness(uvec2 range, vec3 world) {
  vec3 to_novel = normalize(center.xyz - world);
  float best = 0.0;
  for (uint i = range.x; i < range.y && best < 1.0; ++i) {
    uint view = entry(references, i).x & 0x0FFFFFFFu;
    vec4 stored = view_texel(view, 3u);
    float near = smoothstep(0.0, least_cosine, dot(to_novel, normalize(stored.xyz - world)));
    if (near <= best) continue;
    bool rim;
    if (share_left(view, world - stored.xyz, stored.w, rim) > 0.0) best = near;
  }
  return best;
}

void main() {
  uvec4 texel = texelFetch(surfaces, ivec2(gl_FragCoord.xy), 0);
  if (texel.x == kNothing) discard;
  Surface surface = surface_of(texel);
  vec3 world = world_of(gl_FragCoord.xy, surface.z);
  color = vec4(srgb_from_linear(exposure.rgb * surface.fallback),
               1.0 - nearness(entry(zones, surface.zone).xy, world));
}
