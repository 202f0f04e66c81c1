// Samples the photographs of stored views at a point of the surface.

uniform sampler2DArray photographs;  // sRGB colour, linear once read; alpha: validity
#ifdef RAW_TEXELS
// The same texels with colours in sRGB. Mesa's driver in software calls a function for each texel of any other format.
uniform sampler2DArray raw_texels;
#endif
uniform usampler2DArray depths;      // blocks of them, see atlas/views/depth_blocks.h

// Whether the pixel shows a surface past its outline, see outlines.h.
bool is_continued = false;

// Returns whole numbers' quotient, rounded down: exact for numbers up to 2^21, and far faster than the division of
// integers, for which GPUs have no instruction.
vec2 quotient(vec2 number, vec2 divisor) {
  return floor((number + 0.5) / divisor);
}

// Finds the place of a view's image point in the texture array: texels, page; and the pixel where no gutters count.
// Returns false if that tile is not resident.
bool locate(vec4 size, vec2 image, out vec3 texel, out ivec3 pixel) {
  vec2 tile_size = vec2(tiles.xy);
  vec2 tile = quotient(floor(image), tile_size);
  uint slot = entry(tile_slots, uint(size.z) + uint(tile.y) * uint(size.w) + uint(tile.x)).x;
  if (slot == kNothing) return false;
  float columns = float(tiles.w);
  // Rows of all pages are numbered one after another.
  float row = quotient(vec2(slot), vec2(columns)).x;
  float page = quotient(vec2(row), vec2(samples.x)).x;
  vec2 place = vec2(float(slot) - row * columns, row - page * float(samples.x));
  float gutter = float(tiles.z);
  vec2 in_tile = image - tile * tile_size;
  texel = vec3(place * (tile_size + 2.0 * gutter) + gutter + in_tile, page);
  pixel = ivec3(place * tile_size + floor(in_tile), page);
  return true;
}

// 8 bits with a sign, as a share of the most.
float share_of_bits(uint bits) {
  return float(int(bits << 24) >> 24) / 127.0;
}

// The reciprocal of what a view sees at a pixel, as a share of the reciprocal that its depths are shares of; 0 or less
// where that is nothing. `whole`: all pixels around are wholly valid, see atlas/views/depth_blocks.h.
float reciprocal_at(ivec3 pixel, out bool rim, out bool whole) {
  uvec4 block = texelFetch(depths, ivec3(pixel.xy / DEPTH_BLOCK_SIDE, pixel.z), 0);
  whole = (block.x & 0x80000000u) != 0u;
  ivec2 at = pixel.xy % DEPTH_BLOCK_SIDE;
  bool two_planes = (block.x & 0x8000u) != 0u;
  bool flagged = ((at.y < DEPTH_BLOCK_SIDE / 2 ? block.z : block.w) >> (at.y % 4 * 8 + at.x) & 1u) != 0u;
  bool farther = two_planes && flagged;
  float middle = unpackHalf2x16((farther ? block.x >> 16 : block.x) & 0x7FFFu).x;
  vec2 root = vec2(share_of_bits(block.y), share_of_bits(block.y >> 8));
  vec2 slope = two_planes ? root * abs(root) : unpackSnorm2x16(block.y);
  rim = two_planes ? (block.y >> (16 + at.y / 2 * 4 + at.x / 2) & 1u) != 0u : flagged;
  vec2 place = vec2(at) - 0.5 * float(DEPTH_BLOCK_SIDE - 1);
  return middle * (1.0 + MOST_DEPTH_SLOPE * dot(slope, place));
}

// Finds the image point and depth, in a stored view, of a point that lies `away` from its centre. Returns false if it
// is behind the view.
bool image_in(uint view, vec3 away, out vec2 image, out float depth) {
  vec4 x = view_texel(view, 0u);
  vec4 y = view_texel(view, 1u);
  depth = dot(view_texel(view, 2u).xyz, away);
  image = vec2(dot(x.xyz, away), dot(y.xyz, away)) / depth + vec2(x.w, y.w);
  return depth > 0.0;
}

// Returns the level of a photograph, given how many of its pixels a sample of the picture covers.
float level_of(float footprint) {
  if (sampling.z == 0) return 0.0;
  return clamp(log2(max(footprint / SHARP_FOOTPRINT, 1.0)), 0.0, float(sampling.y - 1));
}

// The pixels of a stored view with that focal length that a sample of the picture covers, of a point with these depths
// here and there.
float footprint_of(float focal_length, float z, float depth) {
  return z * focal_length / (SAMPLES_ACROSS * intrinsics.x * depth);
}

// Returns the width of the sampling kernel, in pixels of the photograph, for a surface with that deviation: see
// blend/sampling/footprint.h.
float blurred_footprint(float footprint, float deviation, vec3 to_novel, vec3 to_stored, float focal_length,
                        float depth) {
  if (samples.w == 0 || !(deviation > 0.0)) return footprint;
  float sine = length(cross(normalize(to_novel), normalize(to_stored)));
  float shift = min(deviation * sine * focal_length / depth, MOST_SHIFT);
  if (!(shift > SHARP_SHIFT)) return footprint;
  float wide = max(footprint, 1.0);
  return sqrt(wide * wide + BLUR_OF_SHIFT * (shift * shift - SHARP_SHIFT * SHARP_SHIFT));
}

// The share that is left of a photograph at one of its pixels, by the depth of the point that the pixel shows: see
// blend/geometric_weight.h.
float frame_share(vec2 image, vec2 size, float depth) {
  float fade = depth > weights.w ? FAR_FRAME_FADE : weights.z;
  if (!(fade > 0.0)) return 1.0;
  vec2 share = smoothstep(0.0, fade * min(size.x, size.y), min(image, size - image));
  return share.x * share.y;
}

// Returns the validity at a place of the texture array, 0 where the pixel there has none.
float validity_at(vec3 texel, bool rim) {
  // Beside a rim lie invalid pixels of the surface behind it. Neither side takes anything from the other. Masks are
  // sampled at the finest level: they rise over several pixels.
#ifdef RAW_TEXELS
  vec2 first = floor(texel.xy - 0.5);
  vec2 f = texel.xy - 0.5 - first;
  ivec2 from = max(ivec2(first), 0);
  ivec2 to = min(ivec2(first) + 1, textureSize(raw_texels, 0).xy - 1);
  int page = int(texel.z);
  vec2 upper = vec2(texelFetch(raw_texels, ivec3(from, page), 0).a,
                    texelFetch(raw_texels, ivec3(to.x, from.y, page), 0).a);
  vec2 lower = vec2(texelFetch(raw_texels, ivec3(from.x, to.y, page), 0).a,
                    texelFetch(raw_texels, ivec3(to, page), 0).a);
  vec2 nearer = f.y < 0.5 ? upper : lower;
  float valid = f.x < 0.5 ? nearer.x : nearer.y;
  vec2 between = mix(upper, lower, f.y);
  return rim || !(valid > 0.0) ? valid : mix(between.x, between.y, f.x);
#else
  float valid = texelFetch(photographs, ivec3(texel), 0).a;
  if (rim || !(valid > 0.0)) return valid;
  return textureLod(photographs, vec3(texel.xy / vec2(textureSize(photographs, 0).xy), texel.z), 0.0).a;
#endif
}

// Returns the share that is left of a stored view at a point that lies `away` from its centre, in [0, 1], without the
// factor at rims. Its depths are shares of `depth_scale`. If the result is above 0, `rim` says whether the point is at
// a rim.
float share_left(uint view, vec3 away, float depth_scale, out bool rim) {
  vec2 image;
  float depth;
  vec4 size = view_texel(view, 4u);
  rim = false;
  if (!image_in(view, away, image, depth)) return 0.0;
  if (any(lessThan(image, vec2(0.0))) || any(greaterThanEqual(image, size.xy))) return 0.0;
  vec3 texel;
  ivec3 pixel;
  if (!locate(size, image, texel, pixel)) return 0.0;
  bool whole;
  float seen = depth * reciprocal_at(pixel, rim, whole);
  if (seen > depth_scale * weights.y) return 0.0;
  // Past an outline the view sees what is behind the surface, whose validity says nothing about the surface.
  bool is_past = is_continued && (1.0 + OUTLINE_STEP) * seen < depth_scale;
  rim = rim || is_past;
  float valid = 1.0;
  if (!whole) {
    valid = validity_at(texel, rim);
    if (!(valid > 0.0)) return 0.0;
    if (is_past) valid = 1.0;
  }
  return valid * frame_share(image, size.xy, depth);
}

// Returns the weights of four pixels in a row, see cubic_kernel.h.
vec4 cubic_shares(float f, float width) {
  float g = 1.0 - f;
  vec4 sharp = vec4(-f * g * g, f * f * (3.0 * f - 5.0) + 2.0, g * g * (3.0 * g - 5.0) + 2.0, -g * f * f) / 2.0;
  vec4 smoothing = vec4(g * g * g, f * f * (3.0 * f - 6.0) + 4.0, g * g * (3.0 * g - 6.0) + 4.0, f * f * f) / 6.0;
  return mix(sharp, smoothing, clamp((width * width - 1.0) / 4.0, 0.0, 1.0));
}

vec4 linear_shares(float f) {
  return vec4(0.0, 1.0 - f, f, 0.0);
}

// The colour in one level; beyond the image's border its pixels are repeated. In the variant FILTERED_TAPS pairs of
// texels that count with the same sign are fetched as one by GL's own filter, 9 in place of 16 or 1 in place of 4: see
// cubic_kernel.h. Software does not use it: Mesa's takes one level for 2 x 2 pixels of the picture, and filters by
// reading four texels.
#ifdef FILTERED_TAPS
vec3 color_of_level(vec2 size, vec2 image, vec3 texel, int level, float footprint) {
  float scale = exp2(-float(level));
  vec2 at = image * scale - 0.5;
  float unit = exp2(float(sampling.y - 1));  // a level is of a photograph rounded up to that
  vec2 last = ceil(size / unit) * unit * scale - 1.0;
  vec2 texel_from_pixel = round(texel.xy - image) * scale + 0.5;
  vec2 texels = vec2(textureSize(photographs, level).xy);
#ifndef LINEAR_SAMPLING
  if (level < sampling.x) {
    vec2 first = floor(at);
    vec2 f = at - first;
    vec4 across = cubic_shares(f.x, footprint * scale);
    vec4 down = cubic_shares(f.y, footprint * scale);
    vec3 shares_across = vec3(across.x, across.y + across.z, across.w);
    vec3 shares_down = vec3(down.x, down.y + down.z, down.w);
    vec3 columns = first.x + vec3(-1.0, across.z / shares_across.y, 2.0);
    vec3 rows = first.y + vec3(-1.0, down.z / shares_down.y, 2.0);
    columns = (clamp(columns, 0.0, last.x) + texel_from_pixel.x) / texels.x;
    rows = (clamp(rows, 0.0, last.y) + texel_from_pixel.y) / texels.y;
    vec3 sum = vec3(0.0);
    for (int y = 0; y < 3; ++y) {
      vec3 of_row = vec3(0.0);
      for (int x = 0; x < 3; ++x) {
        of_row += shares_across[x] * textureLod(photographs, vec3(columns[x], rows[y], texel.z), float(level)).rgb;
      }
      sum += shares_down[y] * of_row;
    }
    return max(sum, vec3(0.0));
  }
#endif
  vec2 place = (clamp(at, vec2(0.0), last) + texel_from_pixel) / texels;
  return textureLod(photographs, vec3(place, texel.z), float(level)).rgb;
}
#else
// Returns the colour of a texel in linear light. Raw ones are decoded by the cubic that Mesa's driver takes for those of
// `photographs`, so that pictures stay the same.
vec3 color_of_texel(ivec3 texel, int level) {
#ifdef RAW_TEXELS
  vec3 c = texelFetch(raw_texels, texel, level).rgb;
  vec3 power = ((0.3012 * c + 0.6935) * c + 0.0030) * c + 0.0023;
  return mix(power, c / 12.6, lessThanEqual(c, vec3(15.0 / 255.0)));
#else
  return texelFetch(photographs, texel, level).rgb;
#endif
}

// The rows and columns, of four, that are fetched. Where the picture is sampled linearly at all levels, which the
// variant LINEAR_SAMPLING is for, the outer ones count nothing.
#ifdef LINEAR_SAMPLING
const int kFirstOfFour = 1, kLastOfFour = 2;
#else
const int kFirstOfFour = 0, kLastOfFour = 3;
#endif

vec3 color_of_level(vec2 size, vec2 image, vec3 texel, int level, float footprint) {
  float scale = exp2(-float(level));
  vec2 at = image * scale - 0.5;
  vec2 first = floor(at);
  vec2 f = at - first;
  bool cubic = kLastOfFour == 3 && level < sampling.x;
  vec4 across = cubic ? cubic_shares(f.x, footprint * scale) : linear_shares(f.x);
  vec4 down = cubic ? cubic_shares(f.y, footprint * scale) : linear_shares(f.y);
  int unit = 1 << (sampling.y - 1);  // a level is of a photograph rounded up to that
  ivec2 last = (((ivec2(size) + unit - 1) & -unit) >> level) - 1;
  ivec2 texel_from_pixel = ivec2(round(texel.xy - image)) / (1 << level);
  int page = int(texel.z);
  ivec4 columns = clamp(ivec4(first.x) + ivec4(-1, 0, 1, 2), 0, last.x) + texel_from_pixel.x;
  ivec4 rows = clamp(ivec4(first.y) + ivec4(-1, 0, 1, 2), 0, last.y) + texel_from_pixel.y;
  vec3 sum = vec3(0.0);
  for (int y = kFirstOfFour; y <= kLastOfFour; ++y) {
    vec3 of_row = vec3(0.0);
    for (int x = kFirstOfFour; x <= kLastOfFour; ++x) {
      of_row += across[x] * color_of_texel(ivec3(columns[x], rows[y], page), level);
    }
    sum += down[y] * of_row;
  }
  return max(sum, vec3(0.0));  // beside bright detail it may fall below
}
#endif

// Returns the factor for a colour of a photograph with this gain: see blend/exposure.h.
vec3 shown_gain(vec3 gain, vec3 color) {
  return mix(gain, max(gain, 1.0 / exposure.rgb), smoothstep(CLIPPED_FROM, 1.0, color));
}

// Returns the colour of a view that is valid at `world`, blurred by the deviation of the surface, scene units.
vec3 color_in(uint view, vec3 world, float z, float deviation) {
  vec2 image;
  vec3 texel;
  ivec3 pixel;
  float depth;
  vec4 size = view_texel(view, 4u);
  vec3 away = world - view_texel(view, 3u).xyz;
  image_in(view, away, image, depth);
  locate(size, image, texel, pixel);
  float focal_length = view_texel(view, 2u).w;
  float footprint = sampling.z != 0 ? footprint_of(focal_length, z, depth) : 1.0;
  footprint = blurred_footprint(footprint, deviation, center.xyz - world, -away, focal_length, depth);
  float level = level_of(footprint);
  int next = int(level);
  float part = 1.0 - fract(level);
  float left = 1.0;
  vec3 color = vec3(0.0);
  do {  // one level, or two
    color += part * color_of_level(size.xy, image, texel, next, footprint);
    left -= part;
    part = left;
    ++next;
  } while (left > 0.0);
  return color * shown_gain(view_texel(view, 5u).rgb, color);
}
