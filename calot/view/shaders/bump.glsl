// A normal turned by a height [m] that is known as a number on the screen [Mikkelsen2010].
vec3 bumped(vec3 position, vec3 normal, float height) {
  vec3 x = dFdx(position), y = dFdy(position);
  vec3 along_x = cross(y, normal), along_y = cross(normal, x);
  float area = dot(x, along_x);
  vec3 gradient = sign(area) * (dFdx(height) * along_x + dFdy(height) * along_y);
  return normalize(abs(area) * normal - gradient);
}
