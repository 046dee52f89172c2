// `keypose landmarks bind`: files that hold numbers of a mesh, rewritten so that they can follow
// when the mesh is made anew.
#pragma once

namespace keypose::registration {

/// The program's main after the word `bind`; the exit code.
int BindMain(int argc, char** argv);

}  // namespace keypose::registration
