// Squares that face the camera, drawn out along their motion.
#include "frame.glsl"
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_along;
layout(location = 2) in float in_radius;
layout(location = 3) in vec4 in_look;
out vec3 position;   // of this corner
flat out vec3 middle;
flat out vec3 axis;  // unit, the long axis, on the picture
flat out vec3 side;
flat out float radius;
flat out vec4 look;
out vec2 on_square;  // -1 ... 1

void main() {
  vec2 corner = vec2(gl_VertexID % 2 == 0 ? -1.0 : 1.0, gl_VertexID < 2 ? -1.0 : 1.0);
  vec3 to_eye = normalize(eye.xyz - in_position);
  vec3 along = in_along - dot(in_along, to_eye) * to_eye;
  float length_along = length(along);
  axis = length_along > 1e-6 ? along / length_along : normalize(up.xyz - dot(up.xyz, to_eye) * to_eye);
  side = cross(axis, to_eye);
  middle = in_position;
  radius = in_radius;
  look = in_look;
  on_square = corner;
  position = in_position + side * (corner.x * radius) + axis * (corner.y * (radius + length_along));
  gl_Position = view_projection * vec4(position, 1.0);
}
