#version 300 es
// A picture on the canvas, enlarged where it is smaller, before a background where there is no surface.
precision highp float;
precision highp int;
precision highp sampler2D;

uniform sampler2D image;  // sRGB; alpha 0: no surface
uniform vec4 place;       // of the picture, pixels: left, bottom, width, height
uniform vec3 above, below;

layout(location = 0) out vec4 color;

void main() {
  ivec2 size = textureSize(image, 0);
  vec2 share = (gl_FragCoord.xy - place.xy) / place.zw;
  vec2 at = share * vec2(size) - 0.5;
  vec2 first = floor(at);
  vec2 f = at - first;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    vec2 part = mix(1.0 - f, f, vec2(corner));
    vec4 texel = texelFetch(image, clamp(ivec2(first) + corner, ivec2(0), size - 1), 0);
    if (texel.a > 0.0) sum += part.x * part.y * vec4(texel.rgb, 1.0);
  }
  vec3 background = mix(below, above, smoothstep(0.0, 1.0, share.y));
  // Two levels of noise, so that the gradient has no bands.
  background += (fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) - 0.5) / 128.0;
  color = vec4(sum.rgb + (1.0 - sum.a) * background, 1.0);
}
