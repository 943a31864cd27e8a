// Which of the formats that the core does not read itself a file is of: those that VTK reads, and
// those that nobody here does.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace tetfusion {

enum class ForeignFormat {
  kUnknown,
  kLegacyVtk,
  kXmlVtk,
  kNetCdf,  // Exodus
  kHdf5,    // VTKHDF, CGNS or Exodus: the library tells which
  kAdf,     // CGNS of the old kind
  kXdmf,
  kEnSight,
  kOpenFoam
};

struct FormatGuess {
  ForeignFormat format = ForeignFormat::kUnknown;
  std::string words = "a file of unknown format";  // "a legacy VTK file", ...
  bool is_list = false;                            // of other files: a .pvd
};

// Does the name say an OpenFOAM case? What it names may be empty: the mesh lies beside it.
bool is_openfoam_name(const std::string& path);

// What the first bytes of a file (a few thousand are enough) say that it is; where they say
// nothing its name.
FormatGuess guess_format(const std::string& path, std::span<const std::byte> head);

// Of such a file as is opened for a moment. Throws Error(kIo).
FormatGuess guess_format_of(const std::string& path);

// May one file have several, of which one is read?
bool may_have_time_steps(ForeignFormat format);

// Throws Error(kBadInput) for a file whose first bytes say that it is of a format that is not read,
// with what to do. The name is asked only where `by_name_too`.
void refuse_unread_formats(const std::string& path, std::span<const std::byte> head,
                           bool by_name_too);

}  // namespace tetfusion
