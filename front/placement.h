#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "front/option_list.h"
#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// "FILE[:at=X,Y,Z][:rotate=X,Y,Z][:scale=S][:mirror=AXES]" as an include: the file is mirrored,
/// scaled (S or X,Y,Z), turned about z, then y, then x (degrees), and moved. No FILE means the
/// scene itself. Throws usage_error.
v1::Include parse_placement(std::string_view text);

/// Adds --place to a command that reads a scene; `placements` must outlive the parsing.
void add_place_option(OptionList& list, std::vector<v1::Include>& placements);

}  // namespace tessera
