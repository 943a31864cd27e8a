#include "driver/arrays/rows_in_use.h"

#include <algorithm>

#include "io/source/stream_windows.h"

namespace tetfusion {

BitSet find_rows_in_use(const MeshStream& stream, Association association,
                        const RunContext& context, std::uint64_t cells) {
  const bool of_cells = association == Association::kCell;
  BitSet in_use;
  in_use.resize(of_cells ? stream.cells() : stream.points());
  CellWindow window;
  const auto add = [&](std::uint64_t first, std::uint64_t count) {
    stream.read_cells(first, count, &window);
    for (std::size_t i = 0; i < window.tets.size(); ++i) {
      if (of_cells) {
        in_use.set(window.tet_rows.empty() ? first + i : window.tet_rows[i]);
      } else {
        for (const VertexId v : window.tets[i]) in_use.set(v);
      }
    }
  };
  for_each_window(std::min(cells, stream.cells()), context, add);
  return in_use;
}

BitSet find_rows_of_cells(const MeshStream& stream, const RunContext& context) {
  BitSet in_use;
  in_use.resize(stream.cells());
  CellWindow window;
  const auto add = [&](std::uint64_t first, std::uint64_t count) {
    stream.read_cells(first, count, &window);
    if (window.tet_rows.empty()) {
      for (std::uint64_t i = 0; i < window.tets.size(); ++i) in_use.set(first + i);
    }
    for (const std::uint64_t row : window.tet_rows) in_use.set(row);
    for (const std::uint64_t row : window.lower_rows) in_use.set(row);
  };
  for_each_window(stream.cells(), context, add);
  return in_use;
}

}  // namespace tetfusion
