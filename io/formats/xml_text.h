// Texts that come from somewhere, for a document and for a message.
#pragma once

#include <string>
#include <string_view>

#include "mesh/data_array.h"

namespace tetfusion {

// Text as the value of an XML attribute. What XML 1.0 cannot hold (control characters, broken
// UTF-8) becomes a question mark.
std::string xml_escape(std::string_view text);
// Can it hold all of the text?
bool is_xml_text(std::string_view text);

// A name that a file gives, as every format and every message can hold it: what is not UTF-8 is
// taken for Latin-1, which old programs write, and a control character that XML has no place for
// becomes its number, as %1B.
std::string legible(std::string_view name);
// The same of the names, units and marks of all arrays.
void make_legible(AttributeSet* set);

// Text of a file for a message of one line, whatever its bytes are: question marks for the same,
// and for all that moves a terminal's cursor.
std::string for_message(std::string_view text);

}  // namespace tetfusion
