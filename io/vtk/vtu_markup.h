// What the heads of VTK's XML files say in the same words.
#pragma once

#include <string>
#include <string_view>

#include "mesh/data_array.h"

namespace tetfusion {

// The first tag, of a file of this type; `more` are further attributes, each after a blank.
std::string vtk_file_tag(std::string_view type, std::string_view more = {});

// The attributes of a DataArray's or PDataArray's tag up to its format: type="..." Name="...".
std::string array_attributes(const ArrayInfo& info);

// What such an element has inside: the key that says units; nothing where there are none.
std::string units_element(const ArrayInfo& info);

// Which arrays of the set are active, as attributes, each after a blank; those that are not there
// are left out.
std::string active_attributes(const AttributeSet& set);

}  // namespace tetfusion
