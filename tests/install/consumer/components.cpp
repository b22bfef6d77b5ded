// Uses the two components that need more libraries, so that linking proves they are found.
#include <calot/image/label_map.h>
#include <calot/mesh/surface.h>
#include <calot/picture/picture.h>

#include <exception>
#include <iostream>

int main() {
  const std::vector<calot::Vec3> centre{{0, 0, 0}};
  const calot::Surface ball = calot::ball_surface(centre, 0.01);
  const calot::Image image = calot::render_picture({{.surface = &ball}}, {.width = 64, .height = 64});
  try {
    (void)calot::read_label_map("there is no such file.nii");
    return 1;
  } catch (const std::exception& error) {
    std::cout << error.what() << '\n';
  }
  return image.rgb.size() == 3u * 64 * 64 ? 0 : 1;
}
