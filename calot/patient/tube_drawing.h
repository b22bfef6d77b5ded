// Ducts and arteries drawn into a label map, and joined to what they end at.
#pragma once
#include "calot/patient/label_edit.h"

namespace calot {

struct DrawnTubes {
  std::vector<Centreline> lines;                        ///< of every tube, from joint to joint, about 0.5 mm steps
  std::vector<std::pair<Structure, Structure>> joints;  ///< which touch: a tube and what it ends at
};

/// Draws `given` lines in place of their labels, finds the lines of the other tubes, and joins the ends:
/// - the cystic duct to the gallbladder (or its wall) and to a bile duct; hepatic and common bile duct to each other;
///   cystic arteries to the gallbladder, and to the right hepatic artery where there is one; an aberrant duct to a bile
///   duct where it comes near one. Other ends are free.
/// - An end that stops short of its neighbour by at most `joint_reach` is prolonged into it; where it runs into it, the
///   neighbour keeps its voxels: the tube ends at its surface. Up to there a tube wins over organs, and the thinner of
///   two tubes over the thicker.
/// - A tube is at least 1.8 voxels wide, so that it hangs together; a warning says where that is wider than it is.
/// Throws InputError for an end that is farther from its neighbour (says how far), and for a line that lies in its
/// neighbour altogether.
DrawnTubes draw_tubes(WorkLabels& labels, const std::vector<Centreline>& given, const CompletionOptions& options,
                      std::vector<CompletionStep>& steps, std::vector<std::string>& warnings, Progress& progress);

/// Whether two structures share a voxel face.
bool touches(const WorkLabels& labels, Structure a, Structure b);

}  // namespace calot
