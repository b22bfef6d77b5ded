// What lies between the organs and no segmentation has: the gallbladder's bed, and the fat of Calot's triangle.
#pragma once
#include "calot/patient/label_edit.h"

namespace calot {

/// Fills the gap between gallbladder (or its wall) and liver: unlabelled voxels between the two (the ways to them lead
/// in opposite directions, within 37°), where the gap is at most `bed_reach` wide, with HU of fat or connective tissue.
/// Where the labels touch, as segmentations usually have them, a layer of `bed_thickness` is carved out of both: half
/// from each, but less (a quarter, nothing) from a gallbladder that would lose more than 2 % of its volume. One part. A
/// bed that is there already is kept; only what is empty between is added. A warning where there is none.
void add_gallbladder_bed(WorkLabels& labels, const CtImage& ct, const CompletionOptions& options,
                         std::vector<CompletionStep>& steps, std::vector<std::string>& warnings);

/// Fills Calot's triangle: unlabelled voxels within `triangle_reach` of the surface between cystic duct, hepatic duct
/// and liver that have HU of fat, or of connective tissue within `connective_reach` of duct, artery or gallbladder;
/// averaged over 27 unlabelled voxels first, because of noise. The largest part, closed, holes filled. Fat that is
/// there already is kept; only gaps of it are filled.
/// @param lines  of the tubes, oriented
void add_triangle_fat(WorkLabels& labels, const CtImage& ct, const std::vector<Centreline>& lines,
                      const CompletionOptions& options, std::vector<CompletionStep>& steps,
                      std::vector<std::string>& warnings);

/// Points [m] close together on the surface between the cystic duct, from its mouth to the gallbladder's neck, the bile
/// duct from that mouth up to the liver, and the liver's surface near both. Empty without lines of both ducts.
std::vector<Vec3> triangle_points(const WorkLabels& labels, const std::vector<Centreline>& lines, double step);

}  // namespace calot
