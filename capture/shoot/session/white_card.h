// The flag --white-balance.
#pragma once

#include <string>

#include "capture/shoot/record/side_file.h"

namespace keypose::capture::shoot {

/// @param text  FILE:x,y,w,h, or FILE alone: then the card is searched in it
/// @throws UsageError  no place, and no card is found
/// @throws InputError, DiskError  the file cannot be read, or the place is no grey card
CarriedWhite WhiteOfCard(const std::string& text);

}  // namespace keypose::capture::shoot
