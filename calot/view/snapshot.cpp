#include "calot/view/snapshot.h"

namespace calot {

TissueLook look_of(std::string_view region_name) {
  if (region_name == "liver") return TissueLook::liver;
  if (region_name.find("gallbladder bed") != std::string_view::npos) return TissueLook::bed;
  if (region_name.find("gallbladder") != std::string_view::npos) return TissueLook::gallbladder;
  if (region_name.find("duct") != std::string_view::npos) return TissueLook::duct;
  if (region_name.find("artery") != std::string_view::npos) return TissueLook::artery;
  if (region_name.find("fat") != std::string_view::npos) return TissueLook::fat;
  if (region_name.find("peritoneum") != std::string_view::npos) return TissueLook::peritoneum;
  return TissueLook::soft;
}

}  // namespace calot
