#version 300 es
// A block of a stored view's depths, as atlas/views/depth_blocks.h has it and atlas/views/depth_blocks.cpp finds it.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

uniform sampler2D seen_depths;  // depth of the nearest surface over that of the seen one, 0: nothing; first row below
uniform sampler2D mask;       // twice the validity in 7 bits, and 1 more at rims
uniform ivec2 origin;         // the view's in the page, blocks
uniform ivec2 size;           // the view's, pixels
uniform float nearest;        // the unit of depths over the depth of the nearest surface
uniform float pixels;         // mask pixels in a pixel of the view, along a side

layout(location = 0) out uvec4 block;

const int kSide = DEPTH_BLOCK_SIDE;
const int kPixels = kSide * kSide;
const float kFits = 0.002;
const int kRefinements = 2;
const int kWhollyValid = 127;
const uint kWholeBit = 0x80000000u;
const float kRounding = 1.0 + 1e-6;

float reciprocals[kPixels];  // 1 / depth; 0: no surface
// A bit a pixel: those that may be asked for, those at rims, and those of the farther plane.
uvec2 kept, rims, farther;
bool whole;  // all pixels of the block and those next to it are wholly valid

struct Planes {
  vec2 middle;  // the nearer one's, the farther one's
  vec2 slope;
  float error;
};

bool bit_of(uvec2 bits, int number) {
  return ((number < 32 ? bits.x : bits.y) >> (number & 31) & 1u) != 0u;
}

uvec2 with_bit(uvec2 bits, int number, bool on) {
  uint bit = on ? 1u << (number & 31) : 0u;
  return bits | (number < 32 ? uvec2(bit, 0u) : uvec2(0u, bit));
}

vec2 place_of(int number) {
  return vec2(number % kSide, number / kSide) - 0.5 * float(kSide - 1);
}

// Its validity, and 1 at a rim.
ivec2 mask_at(ivec2 pixel) {
  float grey = texelFetch(mask, min(ivec2((vec2(pixel) + 0.5) * pixels), textureSize(mask, 0) - 1), 0).x;
  int value = int(grey * 255.0 + 0.5);
  return ivec2(value >> 1, value & 1);
}

// Returns whether all pixels of the mask in a pixel of the view are.
bool is_wholly_valid(ivec2 pixel) {
  ivec2 last = textureSize(mask, 0) - 1;
  ivec2 from = min(ivec2(vec2(pixel) * pixels + 1e-3), last);
  ivec2 to = min(ivec2(ceil(vec2(pixel + 1) * pixels - 1e-3)) - 1, last);
  for (int y = from.y; y <= to.y; ++y) {
    for (int x = from.x; x <= to.x; ++x) {
      if (int(texelFetch(mask, ivec2(x, y), 0).x * 255.0 + 0.5) >> 1 != kWhollyValid) return false;
    }
  }
  return true;
}

// Marks pixels that are valid, or have a neighbour that is, and sets `whole`.
uvec2 may_be_asked(ivec2 first) {
  uvec2 asked = uvec2(0u);
  whole = true;
  uint above = 0u, here = 0u;  // rows, with a pixel before and one behind
  for (int y = -1; y <= kSide; ++y) {
    uint row = 0u;
    for (int x = -1; x <= kSide; ++x) {
      ivec2 at = first + ivec2(x, y);
      bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
      if (!inside) continue;
      if (mask_at(at).x != 0) row |= 7u << (x + 1);
      whole = whole && is_wholly_valid(at);
    }
    uint near = (above | here | row) >> 2 & 255u;
    if (y > 0 && y <= kSide / 2) asked.x |= near << kSide * (y - 1);
    if (y > kSide / 2) asked.y |= near << kSide * (y - 1 - kSide / 2);
    above = here;
    here = row;
  }
  return asked;
}

void read_pixels(ivec2 first) {
  uvec2 seen = uvec2(0u);
  rims = uvec2(0u);
  for (int number = 0; number < kPixels; ++number) {
    ivec2 at = first + ivec2(number % kSide, number / kSide);
    reciprocals[number] = 0.0;
    if (any(greaterThanEqual(at, size))) continue;
    float seen_depth = texelFetch(seen_depths, ivec2(at.x, size.y - 1 - at.y), 0).x;
    if (!(seen_depth > 0.0)) continue;
    reciprocals[number] = nearest * seen_depth;
    seen = with_bit(seen, number, true);
    rims = with_bit(rims, number, mask_at(at).y != 0);
  }
  kept = seen & may_be_asked(first);
  if (kept == uvec2(0u)) kept = seen;
}

float at_plane(Planes planes, bool of_farther, int number) {
  return (of_farther ? planes.middle.y : planes.middle.x) * (1.0 + dot(planes.slope, place_of(number)));
}

float error_of(Planes planes) {
  float error = 0.0;
  for (int number = 0; number < kPixels; ++number) {
    if (!bit_of(kept, number)) continue;
    error = max(error, abs(at_plane(planes, bit_of(farther, number), number) / reciprocals[number] - 1.0));
  }
  return error;
}

// In the vectors of two and the columns, the nearer plane's and the farther's.
Planes fitted() {
  vec2 level = vec2(0.0), count = vec2(0.0), weight = vec2(0.0), value = vec2(0.0);
  mat2 place = mat2(0.0);
  for (int number = 0; number < kPixels; ++number) {
    if (!bit_of(kept, number)) continue;
    vec2 of_plane = bit_of(farther, number) ? vec2(0.0, 1.0) : vec2(1.0, 0.0);
    level += of_plane * reciprocals[number];
    count += of_plane;
  }
  level /= max(count, vec2(1.0));
  for (int number = 0; number < kPixels; ++number) {
    if (!bit_of(kept, number)) continue;
    vec2 of_plane = bit_of(farther, number) ? vec2(0.0, 1.0) : vec2(1.0, 0.0);
    float here = reciprocals[number] / dot(of_plane, level);
    weight += of_plane / (here * here);
    value += of_plane / here;
    place += outerProduct(place_of(number), of_plane / (here * here));
  }
  vec2 per_weight = 1.0 / max(weight, vec2(1e-6));
  value *= per_weight;
  place = mat2(place[0] * per_weight.x, place[1] * per_weight.y);
  mat2 spread = mat2(1e-6);
  vec2 along = vec2(0.0);
  for (int number = 0; number < kPixels; ++number) {
    if (!bit_of(kept, number)) continue;
    vec2 of_plane = bit_of(farther, number) ? vec2(0.0, 1.0) : vec2(1.0, 0.0);
    float here = reciprocals[number] / dot(of_plane, level);
    vec2 apart = place_of(number) - place * of_plane;
    spread += outerProduct(apart, apart) / (here * here);
    along += (here - dot(of_plane, value)) / (here * here) * apart;
  }
  vec2 slope = inverse(spread) * along;
  vec2 share = value - slope * place;
  Planes planes;
  planes.middle = level * share;
  // One slope as a share of the middle's value, which is near 1.
  float mean = dot(weight, share) / (weight.x + weight.y);
  planes.slope = mean > 0.0 ? clamp(slope / mean, -MOST_DEPTH_SLOPE, MOST_DEPTH_SLOPE) : vec2(0.0);
  planes.error = error_of(planes);
  return planes;
}

// False: all are equally near.
bool split_at_middle() {
  float least = 1e30, most = 0.0;
  for (int number = 0; number < kPixels; ++number) {
    if (!bit_of(kept, number)) continue;
    least = min(least, reciprocals[number]);
    most = max(most, reciprocals[number]);
  }
  for (int number = 0; number < kPixels; ++number) {
    farther = with_bit(farther, number, reciprocals[number] * reciprocals[number] < least * most);
  }
  return least < most;
}

uvec2 nearer_to_second(Planes planes) {
  uvec2 bits = uvec2(0u);
  for (int number = 0; number < kPixels; ++number) {
    float first = abs(at_plane(planes, false, number) - reciprocals[number]);
    bits = with_bit(bits, number, abs(at_plane(planes, true, number) - reciprocals[number]) < first);
  }
  return bits;
}

Planes two_planes() {
  Planes best = fitted();
  for (int i = 0; i < kRefinements; ++i) {
    uvec2 before = farther;
    farther = nearer_to_second(best);
    bool both = (kept & farther) != uvec2(0u) && (kept & ~farther) != uvec2(0u);
    Planes next = best;
    if (both) next = fitted();
    if (!(next.error < best.error)) {
      farther = before;
      break;
    }
    best = next;
  }
  return best;
}

uint half_below(float value) {
  float wanted = clamp(value, 0.0, 65504.0);
  uint bits = packHalf2x16(vec2(wanted, 0.0));
  return unpackHalf2x16(bits).x > wanted ? bits - 1u : bits;
}

uint lowered_middle(Planes planes, bool of_farther) {
  float over = 1.0;
  for (int number = 0; number < kPixels; ++number) {
    if (!bit_of(kept, number) || bit_of(farther, number) != of_farther) continue;
    over = max(over, at_plane(planes, of_farther, number) / reciprocals[number]);
  }
  return half_below((of_farther ? planes.middle.y : planes.middle.x) / (over * kRounding));
}

uvec4 packed_plane(Planes planes) {
  uint slope = packSnorm2x16(planes.slope / MOST_DEPTH_SLOPE);
  planes.slope = unpackSnorm2x16(slope) * MOST_DEPTH_SLOPE;
  return uvec4(lowered_middle(planes, false), slope, rims);
}

uvec4 packed_pair(Planes planes) {
  farther = nearer_to_second(planes);
  vec2 share = planes.slope / MOST_DEPTH_SLOPE;
  ivec2 root = ivec2(round(127.0 * sign(share) * sqrt(abs(share))));
  planes.slope = vec2(root * abs(root)) / (127.0 * 127.0) * MOST_DEPTH_SLOPE;
  uint middles = lowered_middle(planes, false) | 0x8000u | lowered_middle(planes, true) << 16;
  uint flags = uint(root.x) & 255u | (uint(root.y) & 255u) << 8;
  for (int number = 0; number < kPixels; ++number) {
    if (bit_of(rims, number)) flags |= 1u << (16 + number / (2 * kSide) * 4 + number % kSide / 2);
  }
  return uvec4(middles, flags, farther);
}

void main() {
  read_pixels(kSide * (ivec2(gl_FragCoord.xy) - origin));
  farther = uvec2(0u);
  block = uvec4(0u);
  if (kept == uvec2(0u)) return;
  Planes one = fitted();
  block = packed_plane(one);
  if (one.error > kFits && split_at_middle()) {
    Planes two = two_planes();
    if (two.error < one.error) block = packed_pair(two);
  }
  if (whole) block.x |= kWholeBit;
}
