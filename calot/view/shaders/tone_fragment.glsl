// Light to screen values; alpha holds how bright they look, for the smoothing after it.
#include "frame.glsl"
#include "tone.glsl"
uniform sampler2D color_map;
in vec2 at;
out vec4 color;

void main() {
  vec3 seen = screen_value(tone_curve(texelFetch(color_map, ivec2(gl_FragCoord.xy), 0).rgb));
  color = vec4(seen, dot(seen, vec3(0.299, 0.587, 0.114)));
}
