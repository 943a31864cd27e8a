#include "mesh/fusion_log.h"

#include <cstring>

namespace tetfusion {

namespace {

template <class T>
void append_all(std::span<const T> from, Vector<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

}  // namespace

FusionRecord FusionLog::operator[](std::size_t i) const {
  const Starts& at = starts_[i];
  const bool is_last = i + 1 == starts_.size();
  const auto part = [&](const auto& all, std::uint64_t Starts::*member) {
    const std::uint64_t begin = at.*member;
    const std::uint64_t end = is_last ? all.size() : starts_[i + 1].*member;
    return std::span(all.data() + begin, end - begin);
  };
  FusionRecord record;
  record.kept = at.kept;
  record.error = at.error;
  record.gone = at.gone;
  record.points = part(points_, &Starts::points);
  record.rows = part(rows_, &Starts::rows);
  record.star = part(star_, &Starts::star);
  record.tets = part(tets_, &Starts::tets);
  record.corners = part(corners_, &Starts::tets);
  record.elsewhere = part(elsewhere_, &Starts::elsewhere);
  record.tet_rows = part(tet_rows_, &Starts::tet_rows);
  return record;
}

void FusionLog::append(const FusionRecord& record) {
  starts_.push_back({record.kept, record.error, record.gone, points_.size(), rows_.size(),
                     star_.size(), tets_.size(), elsewhere_.size(), tet_rows_.size()});
  append_all(record.points, &points_);
  append_all(record.rows, &rows_);
  append_all(record.star, &star_);
  append_all(record.tets, &tets_);
  append_all(record.corners, &corners_);
  append_all(record.elsewhere, &elsewhere_);
  append_all(record.tet_rows, &tet_rows_);
}

void FusionLog::save(ByteWriter* out) const {
  out->put_all(starts_);
  out->put_all(points_);
  out->put_all(rows_);
  out->put_all(star_);
  out->put_all(tets_);
  out->put_all(corners_);
  out->put_all(elsewhere_);
  out->put_all(tet_rows_);
}

void FusionLog::load(ByteReader* in) {
  in->get_all(&starts_);
  in->get_all(&points_);
  in->get_all(&rows_);
  in->get_all(&star_);
  in->get_all(&tets_);
  in->get_all(&corners_);
  in->get_all(&elsewhere_);
  in->get_all(&tet_rows_);
}

template <class Real>
std::size_t point_row_bytes(const WorkMesh<Real>& layout) {
  std::size_t bytes = sizeof(Vec3<Real>);
  for (const Column& c : layout.point_columns) bytes += c.stride();
  return bytes;
}

template <class Real>
std::size_t tet_row_bytes(const WorkMesh<Real>& layout) {
  std::size_t bytes = 0;
  for (std::size_t c = 0; c + 1 < layout.cell_columns.size(); ++c) {
    bytes += layout.cell_columns[c].stride();
  }
  return bytes;
}

template <class Real>
void copy_point_row(const WorkMesh<Real>& mesh, std::size_t vertex, std::byte* out) {
  std::memcpy(out, &mesh.positions[vertex], sizeof(Vec3<Real>));
  out += sizeof(Vec3<Real>);
  for (const Column& c : mesh.point_columns) {
    std::memcpy(out, c.rows.data() + vertex * c.stride(), c.stride());
    out += c.stride();
  }
}

template <class Real>
void copy_tet_row(const WorkMesh<Real>& mesh, std::size_t tet, std::byte* out) {
  for (std::size_t i = 0; i + 1 < mesh.cell_columns.size(); ++i) {
    const Column& c = mesh.cell_columns[i];
    std::memcpy(out, c.rows.data() + tet * c.stride(), c.stride());
    out += c.stride();
  }
}

template <class Real>
std::span<const TetId> original_numbers(const WorkMesh<Real>& mesh) {
  const Column& c = mesh.cell_columns.back();
  return {reinterpret_cast<const TetId*>(c.rows.data()), mesh.tets.size()};
}

template std::size_t point_row_bytes(const WorkMesh<float>&);
template std::size_t point_row_bytes(const WorkMesh<double>&);
template std::size_t tet_row_bytes(const WorkMesh<float>&);
template std::size_t tet_row_bytes(const WorkMesh<double>&);
template void copy_point_row(const WorkMesh<float>&, std::size_t, std::byte*);
template void copy_point_row(const WorkMesh<double>&, std::size_t, std::byte*);
template void copy_tet_row(const WorkMesh<float>&, std::size_t, std::byte*);
template void copy_tet_row(const WorkMesh<double>&, std::size_t, std::byte*);
template std::span<const TetId> original_numbers(const WorkMesh<float>&);
template std::span<const TetId> original_numbers(const WorkMesh<double>&);

}  // namespace tetfusion
