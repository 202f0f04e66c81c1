#version 450 core

flat in uint first_face;

layout(location = 0) out uint face;    // its number in the index buffer
layout(location = 1) out float depth;  // z in the camera frame

void main() {
  face = first_face + uint(gl_PrimitiveID);
  depth = 1.0 / gl_FragCoord.w;
}
