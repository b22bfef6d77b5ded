// Inside this room only: the parts of `detect`.
#pragma once
#include "calot/contact/detect.h"

namespace calot::detail {

/// A contact before the reduction.
struct Candidate {
  TissueContact contact;
  double expected = 0;  ///< gap at the step's end if nothing hinders it [m]
  Vec3 at = Vec3::Zero();
};

void find_shape_contacts(const ContactSurface& surface, std::span<const MovingShape> shapes,
                         const ContactOptions& options, std::vector<Candidate>& found);
void find_still_contacts(const ContactSurface& surface, std::span<const StillSurface> still,
                         const ContactOptions& options, std::vector<Candidate>& found);
void find_self_contacts(const ContactSurface& surface, const ContactOptions& options, std::vector<Candidate>& found);

/// One candidate of each key, then a spread-out subset.
std::vector<TissueContact> reduce(const std::vector<Candidate>& found, const ContactOptions& options);

/// Names a pair of features; SplitMix64's mixing of all the parts [Steele2014].
std::uint64_t key_of(std::initializer_list<std::uint64_t> parts);

}  // namespace calot::detail
