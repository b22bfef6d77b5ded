// A layer of liquid on tissue: hides what lies behind it with its depth, and shines.
#include "frame.glsl"
#include "material.glsl"
#include "light.glsl"
#include "tone.glsl"
#include "output.glsl"
#include "particle.glsl"
in vec3 position, normal, liquid_here;  // thickness [m], bile, clot
out vec4 color;

void main() {
  float thickness = max(liquid_here.x, 0.0);
  vec3 n = normalize(normal);
  float opacity = liquid_opacity(thickness, liquid_here.y);
  Material m = liquid(thickness, liquid_here.y, liquid_here.z);
  color = vec4(shown(shade(m, n, position, n, 1.0)) * opacity, opacity);
}
