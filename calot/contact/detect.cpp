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

/// Greedily those far enough from the ones taken, deepest first.
std::vector<std::size_t> spread(const std::vector<const Candidate*>& sorted, double spacing) {
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const Candidate& c = *sorted[i];
    const bool near = std::any_of(taken.begin(), taken.end(), [&](std::size_t j) {
      const Candidate& d = *sorted[j];
      return c.contact.partner == d.contact.partner && c.contact.shape == d.contact.shape &&
             (c.at - d.at).squaredNorm() < spacing * spacing && c.contact.normal.dot(d.contact.normal) > 0.7;
    });
    if (!near) taken.push_back(i);
  }
  return taken;
}

}  // namespace

std::vector<TissueContact> reduce(const std::vector<Candidate>& found, const ContactOptions& options) {
  // The deepest of each key; small records are sorted instead of whole contacts.
  struct Rank {
    std::uint64_t key;
    double expected;
    std::uint32_t index;
  };
  std::vector<Rank> ranks;
  ranks.reserve(found.size());
  for (std::uint32_t i = 0; i < found.size(); ++i) ranks.push_back({found[i].contact.key, found[i].expected, i});
  std::sort(ranks.begin(), ranks.end(), [](const Rank& a, const Rank& b) {
    if (a.key != b.key) return a.key < b.key;
    return a.expected != b.expected ? a.expected < b.expected : a.index < b.index;
  });
  const auto same_key = [](const Rank& a, const Rank& b) { return a.key == b.key; };
  ranks.erase(std::unique(ranks.begin(), ranks.end(), same_key), ranks.end());
  std::sort(ranks.begin(), ranks.end(), [](const Rank& a, const Rank& b) {
    return a.expected != b.expected ? a.expected < b.expected : a.key < b.key;
  });
  std::vector<const Candidate*> sorted;
  for (const Rank& rank : ranks) sorted.push_back(&found[rank.index]);
  double spacing = options.spacing;
  std::vector<std::size_t> taken = spread(sorted, spacing);
  for (int i = 0; i < 12 && taken.size() > options.max_contacts; ++i) {
    spacing *= 1.4;
    taken = spread(sorted, spacing);
  }
  if (taken.size() > options.max_contacts) taken.resize(options.max_contacts);
  std::vector<TissueContact> contacts;
  contacts.reserve(taken.size());
  for (const std::size_t i : taken) contacts.push_back(sorted[i]->contact);
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
  thread_local std::vector<detail::Candidate> found;  // kept for its memory
  found.clear();
  detail::find_shape_contacts(surface, partners.shapes, options, found);
  detail::find_still_contacts(surface, partners.still, options, found);
  if (options.self_contact) detail::find_self_contacts(surface, options, found);
  return detail::reduce(found, options);
}

}  // namespace calot
