#version 300 es
// Writes validities as alpha; the colour mask keeps colours.

precision highp float;
precision highp sampler2DArray;

uniform sampler2DArray masks;

in vec2 texel;
flat in int number;

layout(location = 0) out vec4 color;

void main() {
  color = vec4(0.0, 0.0, 0.0, texelFetch(masks, ivec3(ivec2(texel), number), 0).r);
}
