// What check_patient has to say about ports, camera, triangle, clips and cuts.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "calot/patient/line_place.h"
#include "calot/patient/mesh_probe.h"
#include "calot/patient/patient_check.h"

namespace calot::detail {
namespace {

constexpr double mm = 1e-3;
constexpr double instrument_length = 330 * mm;  // of the shaft, usual
constexpr double farthest_view = 200 * mm;      // farther, the light doesn't carry
constexpr double ports_apart = 20 * mm;         // nearer, the handles collide outside
constexpr double sight_slack = 10 * mm;         // what is nearer to the triangle than this belongs to it
const std::string in_metres = "it looks like metres: write millimetres";

bool at_origin(const Vec3& place) {
  return place.cwiseAbs().maxCoeff() < 1 * mm;
}

/// A place written in metres by mistake: within a millimetre of the origin, but sensible when taken times 1000.
template <class Sensible>
bool looks_like_metres(const Vec3& place, const Sensible& sensible) {
  return at_origin(place) && sensible(Vec3(place * 1e3));
}

class MarkCheck {
 public:
  MarkCheck(const Patient& patient, Findings& findings)
      : patient_(patient),
        marks_(patient.landmarks),
        findings_(findings),
        probe_(patient.mesh),
        tubes_(lines_towards_gallbladder(patient.lines, patient.mesh)),
        centre_((marks_.triangle.duct_corner + marks_.triangle.neck_corner + marks_.triangle.liver_corner) / 3) {}

  void check() {
    // The rest is measured from the triangle.
    if (!check_triangle()) return;
    check_ports();
    check_camera();
    check_sites();
  }

 private:
  [[nodiscard]] std::string organ_at(const Vec3& point) const {
    const std::int32_t region = probe_.region_at(point);
    for (const Structure s : all_structures())
      if (region == label_of(s)) return std::string(name_of(s));
    return "";
  }

  // ---- the triangle ----

  bool check_triangle() {
    const std::string where = "patient.toml, calot_triangle";
    const std::size_t before = findings_.list.size();
    constexpr double reach = 20 * mm;
    const std::array<std::pair<const char*, Vec3>, 3> corners{{{"duct_corner", marks_.triangle.duct_corner},
                                                               {"neck_corner", marks_.triangle.neck_corner},
                                                               {"liver_corner", marks_.triangle.liver_corner}}};
    for (const auto& [name, corner] : corners) {
      const auto near = [&](const Vec3& p) { return !organ_at(p).empty() || probe_.nearest_vertex(p) < reach; };
      if (near(corner)) continue;
      findings_.error(where,
                      std::string(name) + " lies " + mm_text(probe_.nearest_vertex(corner)) + " away from every organ",
                      looks_like_metres(corner, near) ? in_metres : "move it to where the structures meet (RAS mm)");
    }
    const Vec3 &a = corners[0].second, &b = corners[1].second, &c = corners[2].second;
    const double nearest = std::min({(a - b).norm(), (b - c).norm(), (c - a).norm()});
    if (findings_.list.size() == before && (nearest < 1 * mm || (b - a).cross(c - a).norm() < 4 * mm * mm))
      findings_.error(where, "its corners don't span a triangle", "move them apart");
    return findings_.list.size() == before;
  }

  // ---- ports ----

  void check_ports() {
    if (marks_.ports.empty()) {
      findings_.error("patient.toml, ports", "there is no [[port]]: no instrument can enter", "add ports");
      return;
    }
    std::set<std::string> names;
    std::vector<const Port*> sound;
    for (const Port& port : marks_.ports) {
      if (!names.insert(port.name).second)
        findings_.error(port_text(port), "there are two ports of this name", "give each its own");
      if (check_port(port)) sound.push_back(&port);
    }
    for (std::size_t p = 0; p < sound.size(); ++p)
      for (std::size_t q = 0; q < p; ++q) check_apart(*sound[q], *sound[p]);
    if (!names.contains("camera"))
      findings_.error("patient.toml, ports", "there is no port named \"camera\"", "name the laparoscope's port so");
  }

  static std::string port_text(const Port& port) { return "patient.toml, port \"" + brief(port.name) + "\""; }

  bool check_port(const Port& port) {
    const auto sensible = [&](const Vec3& p) {
      return organ_at(p).empty() && (p - centre_).norm() <= instrument_length && (p - centre_).norm() > 30 * mm;
    };
    if (looks_like_metres(port.position, sensible)) {
      findings_.error(port_text(port), "its position lies within a millimetre of the origin", in_metres);
      return false;
    }
    const std::string organ = organ_at(port.position);
    const double reach = (port.position - centre_).norm();
    if (!organ.empty())
      findings_.error(port_text(port), "it lies inside the " + organ, "move it onto the abdominal wall");
    else if (reach > instrument_length)
      findings_.error(port_text(port), "it lies " + mm_text(reach) + " away from Calot's triangle",
                      "instruments are 330 mm long: move it nearer");
    return organ.empty() && reach <= instrument_length;
  }

  void check_apart(const Port& a, const Port& b) {
    const double distance = (a.position - b.position).norm();
    if (distance < ports_apart)
      findings_.error(port_text(b), "it lies " + mm_text(distance) + " away from port \"" + brief(a.name) + "\"",
                      "keep ports 20 mm apart at least, better 50 mm, or their instruments collide");
  }

  // ---- the camera ----

  void check_camera() {
    const std::string where = "patient.toml, camera";
    const CameraPose& camera = marks_.camera;
    const auto near = [&](const Vec3& p) { return (p - centre_).norm() <= farthest_view; };
    const auto sensible_tip = [&](const Vec3& p) {
      return near(p) && organ_at(p).empty() && (p - centre_).norm() > 20 * mm;
    };
    if (looks_like_metres(camera.tip, sensible_tip)) {
      findings_.error(where, "its tip lies within a millimetre of the origin", in_metres);
      return;
    }
    const std::string organ = organ_at(camera.tip);
    const double distance = (camera.tip - centre_).norm();
    if (!organ.empty()) {
      findings_.error(where, "its tip lies inside the " + organ, "pull it back");
    } else if (distance > farthest_view) {
      findings_.error(where, "its tip lies " + mm_text(distance) + " away from Calot's triangle",
                      "bring it within 200 mm");
    } else {
      check_view(where, camera);
    }
  }

  void check_view(const std::string& where, const CameraPose& camera) {
    const Vec3 gaze = (camera.target - camera.tip).normalized(), wanted = (centre_ - camera.tip).normalized();
    const double angle = std::acos(std::clamp(gaze.dot(wanted), -1.0, 1.0)) * 180 / std::numbers::pi;
    if (angle > camera.field_of_view / 2) {
      findings_.error(where,
                      "it looks " + short_number(std::round(angle)) +
                          " degrees away from Calot's triangle, which is "
                          "out of its picture",
                      "put its target on the triangle, near " + toml_mm(Vec3((centre_ * 1e3).array().round() / 1e3)));
      return;
    }
    std::string organ;
    const CalotTriangle& t = marks_.triangle;
    for (const Vec3& aim : {centre_, t.duct_corner, t.neck_corner, t.liver_corner}) {
      const std::string blocker = blocked_by(camera.tip, aim);
      if (blocker.empty()) return;
      if (organ.empty()) organ = blocker;
    }
    findings_.warning(where, "the " + organ + " hides Calot's triangle from it",
                      "move the tip, or lift the organ first when operating");
  }

  /// The large organ that a line of sight meets well before what it aims at; "" if none.
  [[nodiscard]] std::string blocked_by(const Vec3& eye, const Vec3& aim) const {
    const auto hit = probe_.first_hit(eye, aim);
    if (!hit || hit->distance > (aim - eye).norm() - sight_slack) return "";
    for (const Structure s : {Structure::liver, Structure::gallbladder, Structure::gallbladder_wall})
      if (hit->region == label_of(s)) return std::string(name_of(s));
    return "";
  }

  // ---- clips and cuts ----

  void check_sites() {
    std::set<Structure> tubes;
    for (const auto* sites : {&marks_.clips, &marks_.cuts})
      for (const TubeSite& site : *sites) tubes.insert(site.tube);
    for (const Structure tube : {Structure::cystic_duct, Structure::cystic_artery, Structure::second_cystic_artery})
      if (in_mesh(tube)) tubes.insert(tube);
    for (const Structure tube : tubes) check_tube(tube);
  }

  [[nodiscard]] bool in_mesh(Structure s) const {
    const auto& regions = patient_.mesh.regions;
    return std::find(regions.begin(), regions.end(), label_of(s)) != regions.end();
  }

  static std::string site_text(const char* kind, const TubeSite& site) {
    return std::string("patient.toml, ") + kind + " \"" + brief(site.name) + "\"";
  }

  void check_tube(Structure tube) {
    const std::string name(name_of(tube)), where = "patient.toml, clips and cuts of the " + name;
    if (tube != Structure::cystic_duct && tube != Structure::cystic_artery && tube != Structure::second_cystic_artery) {
      findings_.error(where, "the " + name + " must not be divided in this operation", "remove them");
      return;
    }
    if (!in_mesh(tube)) {
      findings_.error(where, "the mesh has no " + name, "remove them, or draw it and run calot patient again");
      return;
    }
    const auto line = tubes_.find(tube);
    if (line == tubes_.end()) {
      findings_.error(where, "there is no centreline of the " + name + " to check them against",
                      "restore it in the centreline file");
      return;
    }
    std::vector<const TubeSite*> clips, cuts;
    bool sound = true;
    for (const TubeSite& site : marks_.clips)
      if (site.tube == tube) clips.push_back(&site), sound = check_site("clip", site, line->second) && sound;
    for (const TubeSite& site : marks_.cuts)
      if (site.tube == tube) cuts.push_back(&site), sound = check_site("cut", site, line->second) && sound;
    if (sound) check_order(where, name, clips, cuts);
  }

  bool check_site(const char* kind, const TubeSite& site, const Centreline& line) {
    const std::string where = site_text(kind, site), tube(name_of(site.tube));
    const LineProjection found = project(line, site.position);
    const LinePlace place = place_at(line, found.arc_length);
    const auto on_tube = [&](const Vec3& p) { return project(line, p).distance <= place.radius + 0.5 * mm; };
    if (!on_tube(site.position)) {
      findings_.error(where, "it lies " + mm_text(found.distance) + " away from the middle of the " + tube,
                      looks_like_metres(site.position, on_tube)
                          ? in_metres
                          : "move it, or delete position, direction and radius to place it by arc_length");
      return false;
    }
    if (std::abs(site.arc_length - found.arc_length) > 1.5 * mm) {
      findings_.error(where,
                      "its arc_length is " + mm_text(site.arc_length) + ", but its position is at " +
                          mm_text(found.arc_length) + " of the " + tube + "'s " + mm_text(length(line)),
                      "delete the wrong one: it is then taken from the other");
      return false;
    }
    if (site.direction.dot(place.direction) < 0.5) {
      findings_.error(where, "its direction isn't that of the " + tube + " towards the gallbladder",
                      "delete direction: it is then taken from the centreline");
      return false;
    }
    if (site.radius > 2 * place.radius + 0.2 * mm || site.radius < place.radius / 2 - 0.2 * mm)
      findings_.warning(where,
                        "its radius is " + mm_text(site.radius) + ", that of the " + tube + " " + mm_text(place.radius),
                        "delete radius: it is then taken from the centreline");
    return true;
  }

  void check_order(const std::string& where, const std::string& name, const std::vector<const TubeSite*>& clips,
                   const std::vector<const TubeSite*>& cuts) {
    if (cuts.empty()) {
      findings_.error(where, "there is no [[cut]] of the " + name, "add one between its clips");
      return;
    }
    for (std::size_t c = 1; c < clips.size(); ++c)
      if (clips[c]->arc_length <= clips[c - 1]->arc_length) {
        findings_.error(site_text("clip", *clips[c]),
                        "it comes after \"" + brief(clips[c - 1]->name) + "\" in the file, but lies before it on the " +
                            name + " (" + mm_text(clips[c]->arc_length) + " against " +
                            mm_text(clips[c - 1]->arc_length) + ")",
                        "give clips from the far side towards the gallbladder");
        return;
      }
    for (const TubeSite* cut : cuts) {
      const auto before = std::count_if(clips.begin(), clips.end(),
                                        [&](const TubeSite* clip) { return clip->arc_length < cut->arc_length; });
      const auto after = static_cast<std::ptrdiff_t>(clips.size()) - before;
      if (before >= 2 && after >= 1) continue;
      findings_.error(site_text("cut", *cut),
                      "it is not between the clips: " + std::to_string(before) + " on the side that stays, " +
                          std::to_string(after) + " on the gallbladder's",
                      "there must be two on the side that stays and one on the gallbladder's: move it");
    }
  }

  const Patient& patient_;
  const Landmarks& marks_;
  Findings& findings_;
  MeshProbe probe_;
  std::map<Structure, Centreline> tubes_;
  Vec3 centre_;
};

}  // namespace

std::string mm_text(double metres) {
  return short_number(std::round(metres * 1e4) / 10) + " mm";
}

void check_landmarks(const Patient& patient, Findings& findings) {
  MarkCheck(patient, findings).check();
}

}  // namespace calot::detail
