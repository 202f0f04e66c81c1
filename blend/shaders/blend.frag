#version 300 es
// Second pass: each visible pixel is the mean of the BLENDED_VIEWS best valid views that its cells refer to. Erat et
// al. 2019, section 3.1; the same formula as blend/reference.cpp. CELLS is how many cells of a zone are looked at, 1, 2
// or 4. A view that several of them refer to is looked at once, and only views that count are asked for colour. In the
// variant SAMPLES a pixel is the mean over its samples; where none sees another surface than its middle, it stays what
// it was. In the variant ONE_CELL all cells of a zone count as one, to which all their references belong, and do not
// fade into each other.

#include "picture.glsl"
#include "fetches.glsl"
#include "surface_texel.glsl"
#include "srgb.glsl"
#include "tables.glsl"
#include "weights.glsl"

uniform usampler2D surfaces;

#ifdef SAMPLES
#define SAMPLES_ACROSS float(samples.y)
#include "silhouettes.glsl"
uniform usampler2D middles;       // the surface at the middles of pixels
uniform sampler2D middle_colors;  // what is shown of that, as `picture`
#else
#define SAMPLES_ACROSS 1.0
#endif

#include "photographs.glsl"

// sRGB, in the variant LINEAR linear light; alpha: PixelState / 255. In the variant COUNT_FETCHES the red channel is the
// number of texels that were fetched.
layout(location = 0) out vec4 picture;

const float kUnseen = 1.0, kUntextured = 2.0, kTextured = 3.0;  // PixelState
const int kRanks = BLENDED_VIEWS + 1;

// The best views of each cell by rank, best first. Indices are known when it is compiled, so that these are registers.
float best[CELLS * (BLENDED_VIEWS + 1)];
uint view_of[CELLS * (BLENDED_VIEWS + 1)];
float counts[CELLS * BLENDED_VIEWS];

// Returns a bit for each cell that is looked at and refers to the view.
uint looking_cells(uint reference) {
#ifdef ONE_CELL
  return cells_of(reference) != 0u ? 1u : 0u;
#else
  return cells_of(reference);
#endif
}

vec3 world_from_pixel(vec2 image, float z) {
  vec3 cam = vec3((image - intrinsics.zw) / intrinsics.xy, 1.0) * z;
  return center.xyz + cam.x * cam_from_world[0].xyz + cam.y * cam_from_world[1].xyz + cam.z * cam_from_world[2].xyz;
}

void forget_views() {
  for (int i = 0; i < CELLS * kRanks; ++i) {
    best[i] = 0.0;
    view_of[i] = 0u;
  }
}

// The least weight that is still among the best of one of these cells.
float least_weight(uint of_cells) {
  float least = 2.0;  // above every weight
  for (int cell = 0; cell < CELLS; ++cell) {
    if ((of_cells >> cell & 1u) != 0u) least = min(least, best[cell * kRanks + BLENDED_VIEWS]);
  }
  return least;
}

void rank_view(uint view, float weight, uint of_cells) {
  for (int cell = 0; cell < CELLS; ++cell) {
    float next = (of_cells >> cell & 1u) != 0u ? weight : 0.0;
    uint next_view = view;
    for (int rank = 0; rank < kRanks; ++rank) {
      int i = cell * kRanks + rank;
      bool better = next > best[i];
      float demoted = best[i];
      uint demoted_view = view_of[i];
      best[i] = better ? next : demoted;
      view_of[i] = better ? next_view : demoted_view;
      next = better ? demoted : next;
      next_view = better ? demoted_view : next_view;
    }
  }
}

// Returns whether a view may be among the best of the cells that refer to it. Validity and the photograph's border can
// only lower its weight.
bool may_win(uvec2 reference, uint of_cells, vec3 world, vec3 to_novel, float o) {
  uint among = looking_cells(reference.x) & of_cells;
  if (among == 0u || sampling.w == 0) return among != 0u;
  float least = least_weight(among);
  if (!(bound_of(reference) > least)) return false;
  vec3 to_stored = view_texel(slot_of(reference.x), 3u).xyz - world;
  return geometric_weight(to_novel, o, to_stored) > least;
}

// Returns whether no view from this reference on can be among the best: all have this bound at most.
bool ends_with(uvec2 reference, uint of_cells) {
  return sampling.w != 0 && !(bound_of(reference) > least_weight(of_cells));
}

void look_at(uint reference, uint of_cells, vec3 world, vec3 to_novel, float o) {
  uint view = slot_of(reference);
  vec4 stored = view_texel(view, 3u);
  bool rim;
  float weight = geometric_weight(to_novel, o, stored.xyz - world);
  float left = share_left(view, world - stored.xyz, stored.w, rim);
  if (rim) left *= rim_share(to_novel, o, stored.xyz - world);
  rank_view(view, faded_weight(weight, left), looking_cells(reference) & of_cells);
}

// The best views of each of the cells; those that cannot win are not looked at. A renderer in software takes both sides
// of a branch, for several pixels at once, and only a loop ends when all of them are done. So each pixel goes on by
// itself, in a loop of its own, to the next view that is worth looking at. Only the number of its reference leaves that
// loop: where the view and its weight were carried out as well, Mesa 22 drew wrong pictures.
void find_views(uvec2 range, uint of_cells, vec3 world) {
  vec3 to_novel = center.xyz - world;
  float o = length(to_novel);
  if (range.x == range.y) return;
  uint next = range.x;
  uint end = range.y;
  do {
    look_at(entry(references, next).x, of_cells, world, to_novel, o);
    bool found = false;
    do {
      ++next;
      if (next < end) {
        uvec2 reference = entry(references, next).xy;
        if (ends_with(reference, of_cells)) end = next;
        found = next < end && may_win(reference, of_cells, world, to_novel, o);
      }
    } while (next < end && !found);
  } while (next < end);
}

// Sets the share of each view in the pixel; returns the sum, 0 if no view is valid.
float count_views(vec4 shares) {
  float total = 0.0;
  for (int cell = 0; cell < CELLS; ++cell) {
    float winner = best[cell * kRanks];
    float last = best[cell * kRanks + BLENDED_VIEWS];
    float share = share_of_cell(shares[cell], winner);
    float sum = 0.0;
    for (int rank = 0; rank < BLENDED_VIEWS; ++rank) sum += share_of(best[cell * kRanks + rank], last, winner);
    for (int rank = 0; rank < BLENDED_VIEWS; ++rank) {
      // If all weigh the same, nothing is left above the last: the best one stands for them.
      float of_cell = sum > 0.0 ? share_of(best[cell * kRanks + rank], last, winner) / sum : rank == 0 ? 1.0 : 0.0;
      counts[cell * BLENDED_VIEWS + rank] = share * of_cell;
    }
    total += share;
  }
  return total;
}

// A view that counts, and what it counts for all cells together, which it is taken away from.
void take_view(out uint view, out float count) {
  bool found = false;
  view = 0u;
  count = 0.0;
  for (int cell = 0; cell < CELLS; ++cell) {
    for (int rank = 0; rank < BLENDED_VIEWS; ++rank) {
      int i = cell * BLENDED_VIEWS + rank;
      uint candidate = view_of[cell * kRanks + rank];
      bool taken = counts[i] > 0.0 && (!found || candidate == view);
      view = taken && !found ? candidate : view;
      count += taken ? counts[i] : 0.0;
      counts[i] = taken ? 0.0 : counts[i];
      found = found || taken;
    }
  }
}

bool any_left() {
  float left = 0.0;
  for (int i = 0; i < CELLS * BLENDED_VIEWS; ++i) left += counts[i];
  return left > 0.0;
}

// False where no view is valid.
bool blend_views(uvec2 range, vec4 shares, vec3 world, float z, float deviation, out vec3 color) {
  uint of_cells = 0u;
  for (int cell = 0; cell < CELLS; ++cell) {
    if (shares[cell] > 0.0) of_cells |= 1u << cell;
  }
  forget_views();
  find_views(range, of_cells, world);
  float total = count_views(shares);
  color = vec3(0.0);
  if (!(total > 0.0)) return false;
  do {
    uint view;
    float count;
    take_view(view, count);
    color += count / total * color_in(view, world, z, deviation);
  } while (any_left());
  return true;
}

// Returns the surface's colour in the picture's exposure, and PixelState, for a pixel that shows it.
vec4 shade(Surface surface, vec2 image) {
#ifdef ONE_CELL
  surface.shares = vec4(1.0, 0.0, 0.0, 0.0);
#endif
  is_continued = surface.is_continued;
  vec3 world = world_from_pixel(image, surface.z);
  uvec4 zone = entry(zones, surface.zone);
  vec3 color;
  float state = kTextured;
  if (!blend_views(zone.xy, surface.shares, world, surface.z, deviation_of(zone), color)) {
    color = surface.fallback;
    state = entry(cells, zone.z).z != 0u ? kUntextured : kUnseen;
  }
  return vec4(exposure.rgb * color, state);
}

#ifdef SAMPLES
// Returns the texel of a sample of the pixel, from the top left on, as sample_cameras() counts them.
ivec2 texel_of_sample(ivec2 first, int i) {
  int row = int(quotient(vec2(i), vec2(samples.y)).x);
  return first + ivec2(i - row * samples.y, samples.y - 1 - row);
}

// Returns those of some samples of the pixel, in bits, that are of the surface at depth z.
uint samples_of(float z, ivec2 first, uint among) {
  uint same = 0u;
  int i = 0;
  for (uint rest = among; rest != 0u; rest >>= 1) {
    bool is_same = is_same_surface(z, depth_at(surfaces, texel_of_sample(first, i)));
    if ((rest & 1u) != 0u && is_same) same |= 1u << i;
    ++i;
  }
  return same;
}

float count_of(uint bits) {
  float count = 0.0;
  for (; bits != 0u; bits &= bits - 1u) count += 1.0;
  return count;
}

vec3 middle_light(ivec2 pixel) {
  vec3 color = texelFetch(middle_colors, pixel, 0).rgb;
#ifdef LINEAR
  return color;
#else
  return linear_from_srgb(color);
#endif
}

// Samples that are of the middle's surface have its colour, and of those of another surface the first is shaded. With
// samples everywhere each is shaded, so that photographs too are sampled that finely.
vec4 shown() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  ivec2 first = pixel * samples.y;
  int across = samples.y;
#ifdef LATE_STENCIL
  if (!is_sampled(middles, pixel)) across = 0;
#endif
  // Samples know nothing of what is continued past outlines.
  if (is_continued_at(middles, pixel)) across = 0;
  uint seen = 0u;
  for (int i = 0; i < across * across; ++i) {
    if (depth_at(surfaces, texel_of_sample(first, i)) > 0.0) seen |= 1u << i;
  }
  uint of_middle = samples.z != 0 ? 0u : samples_of(depth_at(middles, pixel), first, seen);
  if (of_middle == seen) discard;
  float count = count_of(of_middle);
  vec4 sum = vec4(0.0);
  if (count > 0.0) sum = count * vec4(middle_light(pixel), 1.0);
  uint left = seen & ~of_middle;
  while (left != 0u) {
    int i = int(count_of((left & -left) - 1u));
    ivec2 at = texel_of_sample(first, i);
    Surface surface = surface_of(texelFetch(surfaces, at, 0));
    uint of_surface = left & -left;
    if (samples.z == 0) of_surface |= samples_of(surface.z, first, left);
    vec2 image = (vec2(at) + 0.5) / float(samples.y);
    sum += count_of(of_surface) * vec4(shade(surface, vec2(image.x, center.w - image.y)).rgb, 1.0);
    left &= ~of_surface;
  }
  return vec4(sum.rgb / sum.w, 0.0);
}
#else
vec4 shown() {
  // The stencil lets no pixel without a surface pass; to discard here would keep drivers from testing it first.
  uvec4 texel = texelFetch(surfaces, ivec2(gl_FragCoord.xy), 0);
#ifdef LATE_STENCIL
  // Chromium's renderer in software shades what the stencil stops, and runs both sides of a branch, but can skip a loop.
  vec4 color = vec4(0.0);
#ifdef ONE_CELL
  bool is_left = variant_of(texel) != 0;
#else
  bool is_left = variant_of(texel) == CELLS;
#endif
  for (; is_left; is_left = false) {
    color = shade(surface_of(texel), vec2(gl_FragCoord.x, center.w - gl_FragCoord.y));
  }
  return color;
#else
  return shade(surface_of(texel), vec2(gl_FragCoord.x, center.w - gl_FragCoord.y));
#endif
}
#endif

void main() {
  vec4 color = shown();
#ifdef COUNT_FETCHES
  picture = vec4(float(fetches), 0.0, 0.0, color.a / 255.0);
#elif defined(LINEAR)
  picture = vec4(color.rgb, color.a / 255.0);
#else
  picture = vec4(srgb_from_linear(color.rgb), color.a / 255.0);
#endif
}
