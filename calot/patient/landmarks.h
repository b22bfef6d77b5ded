// Places that the operation needs, computed from the anatomy.
#pragma once
#include <string>
#include <vector>

#include "calot/patient/completion.h"

namespace calot {

/// Where an instrument or the camera enters through the abdominal wall.
struct Port {
  std::string name;     ///< "camera", "epigastric", "midclavicular", "anterior axillary"
  Vec3 position;        ///< on the inner side of the lifted wall [m], RAS
  double diameter = 0;  ///< [m], 5e-3 or 10e-3
  std::string purpose;  ///< in words
};

struct CameraPose {
  Vec3 tip, target, up;       ///< of the laparoscope's tip, what it looks at [m]; up is a direction of length 1
  double oblique = 30;        ///< angle of its optic [°]
  double field_of_view = 70;  ///< [°]
};

/// A place across a tube: where it is clipped or cut.
struct TubeSite {
  std::string name;  ///< "cystic duct, clip 1 (towards the bile duct)" …
  Structure tube;
  double arc_length = 0;     ///< along its centreline from the far (bile duct or artery) side [m]
  Vec3 position, direction;  ///< on the centreline [m]; unit tangent towards the gallbladder
  double radius = 0;         ///< of the tube there [m]
};

struct CalotTriangle {
  Vec3 duct_corner;   ///< cystic duct meets the hepatic duct [m]
  Vec3 neck_corner;   ///< cystic duct meets the gallbladder
  Vec3 liver_corner;  ///< where hepatic duct and liver edge meet
};

struct Landmarks {
  std::vector<Port> ports;
  CameraPose camera;
  std::vector<TubeSite> clips;  ///< of every tube that is divided: two on the patient's side, one on the gallbladder's
  std::vector<TubeSite> cuts;   ///< between them
  CalotTriangle triangle;
  std::vector<std::string> notes;  ///< what had to be assumed, e.g. the skin isn't in the CT
};

/// Computes them. Ports lie on the abdominal wall found in the CT (or, where its field ends before, an assumed one),
/// lifted by the pneumoperitoneum; their places follow the usual four-port technique (American position;
/// docs/patient.md has the sources). Throws FailedError where the anatomy lacks what they need (a cystic duct and a
/// bile duct, each with a centreline).
Landmarks find_landmarks(const CompletedAnatomy& anatomy);

}  // namespace calot
