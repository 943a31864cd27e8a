// What all chunks together know of the vertices between them. At the end of a round every chunk
// reports the vertices on its interface; the table joins the reports, and the chunks of the next
// round look up what has become of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// A vertex that more than one chunk has, in this round or in the next, and where its tetrahedra go:
// to chunks `low` up to `high` of the next.
struct InterfaceReport {
  VertexId id = 0;  // point_ids
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint8_t marks = 0;  // VertexMark bits to be set
  bool touched = false;    // its ball has changed
};

// 16 bytes a vertex. Reading is thread-safe.
class InterfaceTable {
 public:
  InterfaceTable() = default;

  // Joins reports, of parts each ascending by id: chunks widen, marks and touches add up. In any
  // order of the parts: the same table. Takes little more memory than they do.
  explicit InterfaceTable(std::vector<Vector<InterfaceReport>> parts);

  // Adds the marks that another table has for the same vertices.
  void add_marks(const InterfaceTable& other);

  // Makes find() quick. To be called when ids have changed; until then it only takes longer.
  void index();

  // Null for a vertex that no chunk has any more, or that was and is in one chunk.
  const InterfaceReport* find(VertexId id) const;

  // Ascending by id, each once; whoever changes them keeps that.
  const Vector<InterfaceReport>& entries() const { return entries_; }
  Vector<InterfaceReport>& entries() { return entries_; }

 private:
  Vector<InterfaceReport> entries_;
  // begins_[i]: of the entries whose id, shifted, is i; the first one. Empty: there is no index.
  Vector<std::uint32_t> begins_;
  int shift_ = 0;
};

}  // namespace tetfusion
