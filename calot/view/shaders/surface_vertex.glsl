// A surface in world space. INSTRUMENT: has a pose; TISSUE: has a rest shape and a condition.
#include "frame.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
invariant gl_Position;

#ifdef TISSUE
layout(location = 2) in vec4 in_condition;
layout(location = 3) in vec3 in_rest;
layout(location = 4) in vec3 in_rest_normal;
out vec4 condition;
out vec3 rest, rest_normal;
#endif
#ifdef INSTRUMENT
layout(location = 5) in vec4 in_grain;  // w: openness
uniform mat4 pose;
out vec3 own_position, own_grain, grain;
out float openness;
#endif
out vec3 position, normal;

void main() {
  position = in_position;
  normal = in_normal;
#ifdef TISSUE
  condition = in_condition;
  rest = in_rest;
  rest_normal = in_rest_normal;
#endif
#ifdef INSTRUMENT
  own_position = in_position;
  own_grain = in_grain.xyz;
  position = (pose * vec4(in_position, 1.0)).xyz;
  normal = mat3(pose) * in_normal;
  grain = mat3(pose) * in_grain.xyz;
  openness = in_grain.w;
#endif
#ifdef SHADOW
  gl_Position = light_view_projection * vec4(position, 1.0);
#else
  gl_Position = view_projection * vec4(position, 1.0);
#endif
}
