// XML libraries read elements recursively, and deep nesting ends their program.
#pragma once

#include <string>
#include <string_view>

namespace keypose {

/// @param where  for the message
/// @throws InputError  elements nested more than 100 levels deep
void RequireShallowXml(std::string_view text, const std::string& where);

}  // namespace keypose
