// What of a shooting session's events a page needs that is opened in the middle of it.
#pragma once

#include <string>
#include <vector>

namespace keypose::studio {

/// Adds an event of `keypose shoot --commands` to those that were kept, and drops what it replaces:
/// a page that reads the rest has the session as one that has read all. What is kept grows with the
/// photographs of a pose, not with the time that it takes. Live pictures are left out.
/// @param line  a JSON object with a text `event`
/// @param events  of one session, in their order
void KeepShootEvent(const std::string& line, std::vector<std::string>* events);

}  // namespace keypose::studio
