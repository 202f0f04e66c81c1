// A texel of a stored photograph, at one of its levels: the mean over the area that it covers, in linear light and by
// validity, as atlas/images/image_levels.cpp and tools/viewer/scaled_view.cpp have it.
#include "../../../../blend/shaders/srgb.glsl"

uniform sampler2D image;  // sRGB as it is in the file, first row above
uniform sampler2D mask;   // twice the validity in 7 bits, and 1 more at rims
uniform float pixels;     // pixels of the photograph in a texel, along a side

// At a place in the view, in texels.
vec4 photograph_texel(ivec2 place) {
  ivec2 size = textureSize(image, 0);
  vec2 from = vec2(place) * pixels;
  vec2 to = from + pixels;
  vec4 valid = vec4(0.0);
  vec4 all = vec4(0.0);
  for (int y = int(floor(from.y + 1e-3)); float(y) < to.y - 1e-3; ++y) {
    float down = min(to.y, float(y) + 1.0) - max(from.y, float(y));
    for (int x = int(floor(from.x + 1e-3)); float(x) < to.x - 1e-3; ++x) {
      float share = down * (min(to.x, float(x) + 1.0) - max(from.x, float(x)));
      ivec2 at = min(ivec2(x, y), size - 1);  // beyond the border its pixels are repeated
      vec4 color = vec4(linear_from_srgb(texelFetch(image, at, 0).rgb), 1.0);
      all += share * color;
      valid += share * float(int(texelFetch(mask, at, 0).x * 255.0 + 0.5) >> 1) / 127.0 * color;
    }
  }
  return vec4((valid.w > 0.0 ? valid.rgb / valid.w : all.rgb / all.w), valid.w / all.w);
}
