#version 300 es
// Finds the stored views that some pixels of a picture would be made of if all were on the GPU, best first, two to a
// number. Occlusion is ignored, because cells refer to views that see them.
#include "../../../../blend/shaders/picture.glsl"
#include "../../../../blend/shaders/surface_texel.glsl"
#include "../../../../blend/shaders/tables.glsl"
#include "../../../../blend/shaders/weights.glsl"

#define SAMPLES_ACROSS 1.0
#include "../../../../blend/shaders/photographs.glsl"
#include "pixel_in_world.glsl"

uniform usampler2D surfaces;

layout(location = 0) out uvec4 needed;

const int kRanks = 8;

float best[kRanks];
uint view_of[kRanks];

void rank_view(uint view, float weight) {
  for (int rank = 0; rank < kRanks; ++rank) {
    bool better = weight > best[rank];
    float demoted = best[rank];
    uint demoted_view = view_of[rank];
    best[rank] = better ? weight : demoted;
    view_of[rank] = better ? view : demoted_view;
    weight = better ? demoted : weight;
    view = better ? demoted_view : view;
  }
}

// Returns which share is left of a view's photograph at the point that lies `away` from its centre; 0: it does not show
// the point.
float frame_at(uint view, vec3 away) {
  vec4 size = view_texel(view, 4u);
  vec2 image;
  float depth;
  bool inside = size.x > 0.0 && image_in(view, away, image, depth) && all(greaterThanEqual(image, vec2(0.0))) &&
                all(lessThan(image, size.xy));
  return inside ? frame_share(image, size.xy, depth) : 0.0;
}

void main() {
  for (int rank = 0; rank < kRanks; ++rank) {
    best[rank] = 0.0;
    view_of[rank] = 0xFFFFu;
  }
  uvec4 texel = texelFetch(surfaces, ivec2(gl_FragCoord.xy), 0);
  if (texel.x != kNothing) {
    vec3 world = world_of(gl_FragCoord.xy, uintBitsToFloat(texel.y));
    vec3 to_novel = center.xyz - world;
    uvec2 range = entry(zones, texel.x).xy;
    for (uint i = range.x; i < range.y; ++i) {
      uint view = entry(references, i).x & 0x0FFFFFFFu;
      vec3 to_stored = view_texel(view, 3u).xyz - world;
      float weight = geometric_weight(to_novel, length(to_novel), to_stored);
      rank_view(view, faded_weight(weight, frame_at(view, -to_stored)));
    }
  }
  needed = uvec4(view_of[0] | view_of[1] << 16, view_of[2] | view_of[3] << 16, view_of[4] | view_of[5] << 16,
                 view_of[6] | view_of[7] << 16);
}
