// A spark's streak of light.
#include "frame.glsl"
#include "material.glsl"
#include "tone.glsl"
#include "output.glsl"
#include "particle.glsl"
in vec2 on_square;
flat in vec4 look;  // heat
out vec4 color;

void main() { color = vec4(shown(spark_light(vec2(on_square.x, 0.5 + 0.5 * on_square.y), look.x)), 0.0); }
