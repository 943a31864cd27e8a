// How long a NetCDF file of the classic formats must be: the library gives zeros for what is not
// there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tetfusion {

// Of a file that begins with these bytes, its header at least: up to the last value of so many
// records, if it has them, and of all variables without records. 0 for other files, and where the
// header does not say.
std::uint64_t netcdf_length(std::span<const std::byte> bytes, std::uint64_t records);

}  // namespace tetfusion
