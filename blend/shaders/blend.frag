#version 450 core
// Second pass: each visible pixel is the mean of the K best valid views that its cell refers to.
// Erat et al. 2019, section 3.1; the same formula as blend/reference.cpp, but a view that several cells of a place refer
// to is looked at once for all of them, and only those that count are sampled for their colour.

// Mirrored by ViewBlock in renderer.cpp.
struct View {
  vec4 cam_from_world[3];  // rows: rotation, translation
  vec4 intrinsics;         // fx, fy, cx, cy
  vec4 center;             // of the camera in the world
  vec4 gain;               // exposure, R G B
  vec4 size;               // width, height in pixels; what its depths are shares of
  uvec4 tiles;             // number of the first, how many are in a row
};

layout(std430, binding = 0) readonly buffer CellOfFace { uint cell_of_face[]; };
layout(std430, binding = 1) readonly buffer Offsets { uint offsets[]; };     // of a cell's references
layout(std430, binding = 2) readonly buffer References { uint slots[]; };
layout(std430, binding = 3) readonly buffer Views { View views[]; };         // by slot = layer
layout(std430, binding = 4) readonly buffer CellSeen { uint cell_seen[]; };
layout(std430, binding = 5) readonly buffer ZoneOfFace { uint zone_of_face[]; };
layout(std430, binding = 6) readonly buffer Zones { uvec4 zones[]; };  // cells that share a face
layout(std430, binding = 7) readonly buffer TileSlots { uint tile_slots[]; };  // by tile: where it is in the array

layout(binding = 0) uniform sampler2DArray photographs;  // sRGB colour, linear once read; alpha: validity
layout(binding = 1) uniform sampler2DArray depths;       // z as a share of the view's size.z, negative at rims
layout(binding = 2) uniform usampler2D faces;
layout(binding = 3) uniform sampler2D surface_depth;
layout(binding = 4) uniform sampler2D fallback_color;
layout(binding = 5) uniform sampler2D cell_shares;  // of the zone's cells

uniform vec4 cam_from_world[3];
uniform vec4 intrinsics;
uniform vec3 center;
uniform float samples_across;  // of a pixel: each covers its share of it
uniform float height;  // of the picture; its first row is the framebuffer's last
uniform uint blended_views;
uniform float lambda;
uniform float occlusion_tolerance;
uniform bool printed_position;
uniform bool rims;
uniform bool fade_last;
uniform bool consistent;
uniform bool skip_losers;
uniform bool prefilter;
uniform int cubic_levels;  // of photographs, that are sampled by catmull_rom.h; 0: linear sampling
uniform uvec2 tile_size;   // pixels, without the gutter
uniform uint gutter;       // pixels
uniform uvec2 page_slots;  // columns and rows of slots in a page of the array
uniform vec3 exposure;  // of the picture: linear light of the model times this is shown

const uint kNoFace = 0xFFFFFFFFu;
const uint kNotResident = 0xFFFFFFFFu;
const float kEmpty = 0.0, kUnseen = 1.0, kUntextured = 2.0, kTextured = 3.0;  // PixelState

// sRGB, in the variants LINEAR and SAMPLE linear light; alpha: PixelState / 255, in SAMPLE 1 where there is a surface.
layout(location = 0) out vec4 picture;

#include "srgb.glsl"

vec3 world_from_pixel(vec2 image, float z) {
  vec3 cam = vec3((image - intrinsics.zw) / intrinsics.xy, 1.0) * z;
  return center + cam.x * cam_from_world[0].xyz + cam.y * cam_from_world[1].xyz + cam.z * cam_from_world[2].xyz;
}

float geometric_weight(vec3 to_novel, float o, vec3 to_stored) {
  float i = length(to_stored);
  if (!(o > 0.0 && i > 0.0)) return 0.0;
  // What is missing to 1 is summed up, which is exact where it is small: 1 minus the cosine is half the square of the
  // distance between the two directions' unit vectors.
  vec3 apart = to_novel / o - to_stored / i;
  float lacks_dir = min(1.0, 0.5 * dot(apart, apart));
  float lacks_pos = printed_position ? min(1.0, o / i) : abs(o - i) / max(o, i);
  return 1.0 - (lambda * lacks_dir + (1.0 - lambda) * lacks_pos);
}

// What a view of this weight counts in a pixel, up to a factor that all views have in common.
float share_of(float weight, float threshold) {
  if (!(weight > 0.0)) return 0.0;
  return (weight - threshold) / (consistent ? max(1.0 - weight, LEAST_PENALTY) : 1.0);
}

// By what the weight counts at a rim of what the stored view sees.
float rim_share(vec3 to_novel, float o, vec3 to_stored) {
  float i = length(to_stored);
  return rims && o > 0.0 && i > 0.0 ? smoothstep(RIM_FAR_COSINE, RIM_NEAR_COSINE, dot(to_novel, to_stored) / (o * i)) : 0.0;
}

// Where in the texture array an image position of a view is: texels, page. False: that tile is not resident.
bool locate(uint view, vec2 image, out vec3 texel) {
  uvec2 tile = uvec2(image) / tile_size;
  uint slot = tile_slots[views[view].tiles.x + tile.y * views[view].tiles.y + tile.x];
  if (slot == kNotResident) return false;
  uint in_page = slot % (page_slots.x * page_slots.y);
  uvec2 place = uvec2(in_page % page_slots.x, in_page / page_slots.x);
  uvec2 origin = place * (tile_size + 2u * gutter) + gutter;
  texel = vec3(vec2(origin) + (image - vec2(tile * tile_size)), float(slot / (page_slots.x * page_slots.y)));
  return true;
}

// Where in a stored view's image a point is, and how deep; false: not in it.
bool image_in(uint view, vec3 world, out vec2 image, out float depth) {
  vec4 at = vec4(world, 1.0);
  vec3 cam = vec3(dot(views[view].cam_from_world[0], at), dot(views[view].cam_from_world[1], at),
                  dot(views[view].cam_from_world[2], at));
  if (!(cam.z > 0.0)) return false;
  image = views[view].intrinsics.xy * cam.xy / cam.z + views[view].intrinsics.zw;
  depth = cam.z;
  return all(greaterThanEqual(image, vec2(0.0))) && all(lessThan(image, views[view].size.xy));
}

// How many pixels of a stored view a sample of the picture covers, of a point with these depths here and there.
float footprint_in(uint view, float z, float depth) {
  return z * views[view].intrinsics.x / (samples_across * intrinsics.x * depth);
}

// Place in the texture array of what a stored view shows of a point, its footprint there, and whether it is at a rim;
// false where valid() is 0 whatever the mask says.
bool project(uint view, vec3 world, float z, out vec3 texel, out float footprint, out bool rim) {
  vec2 image;
  float depth;
  if (!image_in(view, world, image, depth)) return false;
  if (!locate(view, image, texel)) return false;
  float stored = texelFetch(depths, ivec3(texel), 0).x * views[view].size.z;
  rim = stored < 0.0;
  footprint = footprint_in(view, z, depth);
  return depth <= abs(stored) * (1.0 + occlusion_tolerance);
}

float level_of(float footprint) {
  return prefilter ? log2(max(footprint / SHARP_FOOTPRINT, 1.0)) : 0.0;
}

// The texture has no more levels than its gutter allows.
vec4 linear_sample(vec3 texel, float level) {
  return textureLod(photographs, vec3(texel.xy / vec2(textureSize(photographs, 0).xy), texel.z), level);
}

vec4 sample_photograph(uint view, vec3 texel, float footprint) {
  vec4 color = linear_sample(texel, level_of(footprint));
  return vec4(color.rgb * views[view].gain.rgb, color.a);
}

// Those of cubic_kernel.h.
vec4 cubic_shares(float f, float width) {
  float g = 1.0 - f;
  vec4 sharp = vec4(-f * g * g, f * f * (3.0 * f - 5.0) + 2.0, g * g * (3.0 * g - 5.0) + 2.0, -g * f * f) / 2.0;
  vec4 smoothing = vec4(g * g * g, f * f * (3.0 * f - 6.0) + 4.0, g * g * (3.0 * g - 6.0) + 4.0, f * f * f) / 6.0;
  return mix(sharp, smoothing, clamp((width * width - 1.0) / 4.0, 0.0, 1.0));
}

// The colour in one level; beyond the image's border its pixels are repeated.
vec3 cubic_color(uint view, vec2 image, vec3 texel, int level, float footprint) {
  float width = footprint * exp2(-float(level));
  vec2 at = image * exp2(-float(level)) - 0.5;
  vec2 first = floor(at);
  vec4 across = cubic_shares(at.x - first.x, width);
  vec4 down = cubic_shares(at.y - first.y, width);
  int unit = 1 << (textureQueryLevels(photographs) - 1);  // a level is of a photograph rounded up to that
  ivec2 last = (((ivec2(views[view].size.xy) + unit - 1) & -unit) >> level) - 1;
  ivec2 texel_from_pixel = ivec2(round(texel.xy - image)) / (1 << level);
  vec3 sum = vec3(0.0);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      ivec2 pixel = clamp(ivec2(first) + ivec2(x - 1, y - 1), ivec2(0), last);
      sum += down[y] * across[x] * texelFetch(photographs, ivec3(pixel + texel_from_pixel, int(texel.z)), level).rgb;
    }
  }
  return max(sum, vec3(0.0));  // beside bright detail it may fall below
}

vec3 color_of_level(uint view, vec2 image, vec3 texel, int level, float footprint) {
  if (level < cubic_levels) return cubic_color(view, image, texel, level, footprint);
  return linear_sample(texel, float(level)).rgb;
}

// Of a view that is valid here.
vec3 sharp_color(uint view, vec3 world, float z) {
  vec2 image;
  vec3 texel;
  float depth;
  image_in(view, world, image, depth);
  locate(view, image, texel);
  float footprint = prefilter ? footprint_in(view, z, depth) : 1.0;
  float level = min(level_of(footprint), float(textureQueryLevels(photographs) - 1));
  vec3 color = color_of_level(view, image, texel, int(level), footprint);
  if (fract(level) > 0.0) color = mix(color, color_of_level(view, image, texel, int(level) + 1, footprint), fract(level));
  return color * views[view].gain.rgb;
}

// Of a view that is valid here.
vec3 color_in(uint view, vec3 world, float z) {
  if (cubic_levels > 0) return sharp_color(view, world, z);
  vec3 texel;
  float footprint;
  bool rim;
  project(view, world, z, texel, footprint, rim);
  return sample_photograph(view, texel, footprint).rgb;
}

// The best views of the cells so far at a place, each once, with its weight, which is the same for every cell, and by
// how much it counts for the cells together.
uint found_views[4 * (MAX_BLENDED_VIEWS + 1)];
float found_weights[4 * (MAX_BLENDED_VIEWS + 1)];
float found_shares[4 * (MAX_BLENDED_VIEWS + 1)];
uint found = 0u;

uint place_of(uint view) {
  uint place = 0u;
  while (place < found && found_views[place] != view) ++place;
  return place;
}

// 0 where it is not valid, or where it weighs no more than `least`, if losers are skipped.
float weight_of(uint view, vec3 world, float z, vec3 to_novel, float o, float least) {
  vec3 to_stored = views[view].center.xyz - world;
  float weight = geometric_weight(to_novel, o, to_stored);
  if (skip_losers && weight <= least) return 0.0;  // validity can only lower it
  vec3 texel;
  float footprint;
  bool rim;
  if (!project(view, world, z, texel, footprint, rim)) return 0.0;
  if (rim) weight *= rim_share(to_novel, o, to_stored);
  return weight * sample_photograph(view, texel, footprint).a;
}

// Adds the K best of a cell, by what they count, to those found. Gives what the cell counts, 0 where no view is valid:
// its share of the place and, as for views, by what its best one lacks.
float find_views(uint cell, float share, vec3 world, float z) {
  float best[MAX_BLENDED_VIEWS + 1];  // weights; best first
  uint views_of[MAX_BLENDED_VIEWS + 1];
  for (uint rank = 0u; rank <= blended_views; ++rank) best[rank] = 0.0;
  vec3 to_novel = center - world;
  float o = length(to_novel);
  for (uint reference = offsets[cell]; reference < offsets[cell + 1u]; ++reference) {
    uint view = slots[reference];
    uint place = place_of(view);
    float next = place < found ? found_weights[place] : weight_of(view, world, z, to_novel, o, best[blended_views]);
    for (uint rank = 0u; rank <= blended_views; ++rank) {
      if (next > best[rank]) {
        float demoted = best[rank];
        best[rank] = next;
        next = demoted;
        uint demoted_view = views_of[rank];
        views_of[rank] = view;
        view = demoted_view;
      }
    }
  }
  if (!(best[0] > 0.0)) return 0.0;
  if (consistent) share /= max(1.0 - best[0], LEAST_PENALTY);
  float threshold = fade_last ? best[blended_views] : 0.0;
  float total = 0.0;
  for (uint rank = 0u; rank < blended_views; ++rank) {
    total += share_of(best[rank], threshold);
  }
  for (uint rank = 0u; rank <= blended_views; ++rank) {
    if (!(best[rank] > 0.0)) break;
    uint place = place_of(views_of[rank]);
    if (place == found) {
      found_views[place] = views_of[rank];
      found_weights[place] = best[rank];
      found_shares[place] = 0.0;
      ++found;
    }
    // Where all K + 1 weigh the same, nothing is left above the last: the best one stands for them.
    float of_cell = total > 0.0 ? share_of(best[rank], threshold) / total : rank == 0u ? 1.0 : 0.0;
    if (rank < blended_views) found_shares[place] += share * of_cell;
  }
  return share;
}

// The mean of what the cells of a zone make of a place, by their shares.
bool blend_cells(uvec4 cells, vec4 shares, vec3 world, float z, out vec3 color) {
  float total = 0.0;
  for (int i = 0; i < 4; ++i) {
    if (shares[i] > 0.0) total += find_views(cells[i], shares[i], world, z);
  }
  color = vec3(0.0);
  for (uint place = 0u; place < found; ++place) {
    if (found_shares[place] > 0.0) color += found_shares[place] / total * color_in(found_views[place], world, z);
  }
  return total > 0.0;
}

#ifdef DIAGNOSE
#include "diagnosis.glsl"
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint face = texelFetch(faces, pixel, 0).x;
  if (face == kNoFace) {
    picture = vec4(0.0, 0.0, 0.0, kEmpty);
#ifdef DIAGNOSE
    diagnosis = kNoDiagnosis;
#endif
    return;
  }
  vec2 image = vec2(gl_FragCoord.x, height - gl_FragCoord.y);
  float z = texelFetch(surface_depth, pixel, 0).x;
  vec3 world = world_from_pixel(image, z);
  vec3 color = vec3(0.0);
  float state = kTextured;
#ifdef DIAGNOSE
  bool textured = diagnose(cell_of_face[face], world, z);
#else
  bool textured = blend_cells(zones[zone_of_face[face]], texelFetch(cell_shares, pixel, 0), world, z, color);
#endif
  if (!textured) {
    color = texelFetch(fallback_color, pixel, 0).rgb;
    state = cell_seen[cell_of_face[face]] != 0u ? kUntextured : kUnseen;
  }
  vec3 shown = exposure * color;
#if defined(SAMPLE)
  picture = vec4(shown, 1.0);
#elif defined(LINEAR)
  picture = vec4(shown, state / 255.0);
#else
  picture = vec4(srgb_from_linear(shown), state / 255.0);
#endif
}
