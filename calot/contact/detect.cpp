#include "calot/contact/detect.h"

#include <algorithm>

#include "calot/base/error.h"
#include "calot/contact/detect_parts.h"

namespace calot {
namespace detail {

std::uint64_t key_of(std::initializer_list<std::uint64_t> parts) {
  std::uint64_t state = 0;
  for (const std::uint64_t part : parts) {
    std::uint64_t z = (state ^ part) + 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    state = z ^ (z >> 31);
  }
  return state;
}

namespace {

/// The deepest of each key, then greedily those far enough from the ones taken, deepest first.
std::vector<std::size_t> spread(const std::vector<Candidate>& sorted, double spacing) {
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const Candidate& c = sorted[i];
    const bool near = std::any_of(taken.begin(), taken.end(), [&](std::size_t j) {
      const Candidate& d = sorted[j];
      return c.contact.partner == d.contact.partner && c.contact.shape == d.contact.shape &&
             (c.at - d.at).squaredNorm() < spacing * spacing && c.contact.normal.dot(d.contact.normal) > 0.7;
    });
    if (!near) taken.push_back(i);
  }
  return taken;
}

}  // namespace

std::vector<TissueContact> reduce(std::vector<Candidate> found, const ContactOptions& options) {
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.contact.key != b.contact.key ? a.contact.key < b.contact.key : a.expected < b.expected;
  });
  found.erase(std::unique(found.begin(), found.end(),
                          [](const Candidate& a, const Candidate& b) { return a.contact.key == b.contact.key; }),
              found.end());
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.expected != b.expected ? a.expected < b.expected : a.contact.key < b.contact.key;
  });
  double spacing = options.spacing;
  std::vector<std::size_t> taken = spread(found, spacing);
  for (int i = 0; i < 12 && taken.size() > options.max_contacts; ++i) {
    spacing *= 1.4;
    taken = spread(found, spacing);
  }
  if (taken.size() > options.max_contacts) taken.resize(options.max_contacts);
  std::vector<TissueContact> contacts;
  contacts.reserve(taken.size());
  for (const std::size_t i : taken) contacts.push_back(found[i].contact);
  return contacts;
}

}  // namespace detail

std::vector<TissueContact> detect(ContactSurface& surface, std::span<const Vec3> positions,
                                  std::span<const Vec3> motion, const ContactPartners& partners,
                                  const ContactOptions& options) {
  for (std::size_t s = 0; s < partners.shapes.size(); ++s) {
    const MovingShape& moving = partners.shapes[s];
    if (moving.shape == nullptr) throw InputError("contact shape " + std::to_string(s), "it has no pieces");
    for (const RoundedPiece& piece : moving.shape->pieces)
      if (!(piece.radius > 0) || piece.corner_count < 1 || piece.corner_count > 3)
        throw InputError("contact shape " + std::to_string(s), "a piece has no radius or no corners");
  }
  surface.refit(positions, motion, options.margin);
  std::vector<detail::Candidate> found;
  detail::find_shape_contacts(surface, partners.shapes, options, found);
  detail::find_still_contacts(surface, partners.still, options, found);
  if (options.self_contact) detail::find_self_contacts(surface, options, found);
  return detail::reduce(std::move(found), options);
}

}  // namespace calot
