// Liquid that lies or hangs on tissue.
#include "frame.glsl"
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec3 in_liquid;  // thickness [m], bile, clot
out vec3 position, normal, liquid_here;

void main() {
  position = in_position;
  normal = in_normal;
  liquid_here = in_liquid;
  gl_Position = view_projection * vec4(in_position + 0.0001 * normalize(eye.xyz - in_position), 1.0);
}
