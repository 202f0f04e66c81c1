// Counts the texels that a fragment shader fetches, in the variant COUNT_FETCHES, by macros that take the place of
// GLSL's own functions: whatever the shader calls is counted. A filtered texel is one.
#ifdef COUNT_FETCHES
int fetches = 0;
#define texelFetch(sampler, place, level) (++fetches, texelFetch(sampler, place, level))
#define textureLod(sampler, place, level) (++fetches, textureLod(sampler, place, level))
#endif
