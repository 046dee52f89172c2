// Photographs that come to a pose on the pages.
#pragma once

#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// Adds a file to a pose's folder of photographs. Never replaces one with other content, but the
/// one that it is said to take the place of: that goes to the bin, and the new one gets its name.
/// @param replaces  of a photograph; empty: none
/// @throws UsageError  no photograph's name, or another photograph of that name is there
void AddPhotograph(Snapshot& snapshot, const std::string& pose, const std::string& name,
                   const std::string& bytes, const std::string& replaces = "");

}  // namespace keypose::studio
