// Arguments that come after a program has started.
//
// Loading the shared libraries of a stage takes longer than a small piece of work. Who will need a
// stage soon starts it with `--await` alone, and writes the arguments when they are known.
#pragma once

#include <string>
#include <vector>

namespace keypose::internal {

/// Reads arguments to the end of a descriptor; each ends with a zero byte. It waits for them.
/// @return empty: nobody needs the program, or the last argument is cut off
std::vector<std::string> AwaitArguments(int descriptor);

}  // namespace keypose::internal
