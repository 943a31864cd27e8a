#include "kernel/fuse_log.h"

#include <algorithm>
#include <type_traits>

#include "kernel/criteria.h"

namespace tetfusion {

namespace {

template <class T>
void fuse_tuple(const FuseRecord& record, std::uint8_t nearest, std::span<const std::uint64_t> rows,
                std::size_t components, T* values) {
  std::array<T*, 4> tuple{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint64_t row = rows.empty() ? record.points[i] : rows[record.points[i]];
    tuple[i] = values + row * components;
  }
  if constexpr (std::is_floating_point_v<T>) {
    for (std::size_t k = 0; k < components; ++k) {
      tuple[0][k] =
          static_cast<T>(mean_of_four(tuple[0][k], tuple[1][k], tuple[2][k], tuple[3][k]));
    }
  } else {
    std::copy_n(tuple[nearest], components, tuple[0]);
  }
}

}  // namespace

void carry_point_array(const FuseLog& log, std::span<const std::uint64_t> rows, DataArray* array) {
  const std::size_t components = array->info.components;
  visit_type(array->info.type, [&](auto zero) {
    using T = decltype(zero);
    T* values = array->as<T>().data();
    std::size_t begin = 0;
    for (const std::size_t end : log.pass_ends) {
#pragma omp parallel for schedule(static)
      for (std::int64_t i = static_cast<std::int64_t>(begin); i < static_cast<std::int64_t>(end);
           ++i) {
        const auto r = static_cast<std::size_t>(i);
        fuse_tuple(log.records[r], log.nearest[r], rows, components, values);
      }
      begin = end;
    }
  });
}

}  // namespace tetfusion
