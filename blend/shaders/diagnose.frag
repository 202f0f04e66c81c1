#version 300 es
// Writes the views and weights of a pixel's own cell, see blend/diagnosis.h. It takes the place of blend.frag, which
// leaves out views that cannot win; here each is looked at.

#include "picture.glsl"
#include "surface_texel.glsl"
#include "tables.glsl"
#include "weights.glsl"

uniform usampler2D surfaces;

#define SAMPLES_ACROSS 1.0
#include "photographs.glsl"

layout(location = 0) out vec4 picture;  // alpha: PixelState / 255
// The number of valid views, the best one's slot, and the shares of the three best in 16 bits each.
layout(location = 1) out uvec4 diagnosis;

const int kRanks = BLENDED_VIEWS + 1;

float ranked[BLENDED_VIEWS + 1];

void rank_weight(float next) {
  for (int rank = 0; rank < kRanks; ++rank) {
    float demoted = min(ranked[rank], next);
    ranked[rank] = max(ranked[rank], next);
    next = demoted;
  }
}

// Those of the three best in the picture; they may sum to less than 1.
vec3 shares_of_best() {
  vec3 shares = vec3(0.0);
  float total = 0.0;
  for (int rank = 0; rank < BLENDED_VIEWS; ++rank) {
    float share = share_of(ranked[rank], ranked[BLENDED_VIEWS], ranked[0]);
    total += share;
    if (rank < 3) shares[rank] = share;
  }
  return total > 0.0 ? shares / total : vec3(ranked[0] > 0.0 ? 1.0 : 0.0, 0.0, 0.0);
}

void main() {
  Surface surface = surface_of(texelFetch(surfaces, ivec2(gl_FragCoord.xy), 0));
  if (surface.zone == kNothing) discard;
  is_continued = surface.is_continued;
  vec2 image = vec2(gl_FragCoord.x, center.w - gl_FragCoord.y);
  vec3 cam = vec3((image - intrinsics.zw) / intrinsics.xy, 1.0) * surface.z;
  vec3 to_novel = -(cam.x * cam_from_world[0].xyz + cam.y * cam_from_world[1].xyz + cam.z * cam_from_world[2].xyz);
  vec3 world = center.xyz - to_novel;
  float o = length(to_novel);
  for (int rank = 0; rank < kRanks; ++rank) ranked[rank] = 0.0;
  uint valid_views = 0u;
  uint winner = kNothing;
  uvec4 cell = entry(cells, entry(zones, surface.zone).z);
  for (uint i = cell.x; i < cell.y; ++i) {
    uint view = slot_of(entry(references, i).x);
    vec4 stored = view_texel(view, 3u);
    bool rim;
    float left = share_left(view, world - stored.xyz, stored.w, rim);
    if (rim) left *= rim_share(to_novel, o, stored.xyz - world);
    if (left > 0.0) ++valid_views;
    float weight = faded_weight(geometric_weight(to_novel, o, stored.xyz - world), left);
    if (weight > ranked[0]) winner = view;
    rank_weight(weight);
  }
  vec3 shares = shares_of_best();
  diagnosis = uvec4(valid_views, winner, packUnorm2x16(shares.xy), packUnorm2x16(vec2(shares.z, 0.0)));
  picture = vec4(0.0, 0.0, 0.0, (winner != kNothing ? 3.0 : cell.z != 0u ? 2.0 : 1.0) / 255.0);
}
