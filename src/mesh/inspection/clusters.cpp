#include "mesh/inspection/clusters.h"

#include "base/union_find.h"

namespace tetfusion {

namespace {

std::uint32_t inverted_colour(const std::array<Cluster, 2>& colours) {
  if (colours[0].cells != colours[1].cells) return colours[1].cells < colours[0].cells ? 1 : 0;
  if (colours[0].rewound != colours[1].rewound) {
    return colours[1].rewound > colours[0].rewound ? 1 : 0;
  }
  return colours[1].first > colours[0].first ? 1 : 0;
}

}  // namespace

Vector<std::uint8_t> find_inverted_clusters(std::span<const Cluster> clusters,
                                            std::span<const Fold> folds) {
  // In an order that depends on the mesh alone: it matters where folds contradict each other.
  const auto by_first_cell = [&](const Fold& fold) {
    return std::minmax(clusters[fold[0]].first, clusters[fold[1]].first);
  };
  Vector<Fold> ordered(folds.begin(), folds.end());
  std::sort(ordered.begin(), ordered.end(),
            [&](const Fold& a, const Fold& b) { return by_first_cell(a) < by_first_cell(b); });
  ColourUnionFind groups(clusters.size());
  for (const Fold& fold : ordered) groups.unite(fold[0], fold[1], true);
  Vector<std::array<Cluster, 2>> colours(clusters.size(), std::array<Cluster, 2>{});
  for (std::uint32_t c = 0; c < clusters.size(); ++c) {
    const auto root = groups.find(c);
    colours[root.id][root.other ? 1 : 0].add(clusters[c]);
  }
  Vector<std::uint8_t> inverted(clusters.size(), 0);
  for (std::uint32_t c = 0; c < clusters.size(); ++c) {
    const auto root = groups.find(c);
    const auto& both = colours[root.id];
    if (both[0].cells == 0 || both[1].cells == 0) continue;
    inverted[c] = inverted_colour(both) == (root.other ? 1u : 0u) ? 1 : 0;
  }
  return inverted;
}

}  // namespace tetfusion
