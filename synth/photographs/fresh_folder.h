// Folders that hold pictures of one world only.
#pragma once

#include <filesystem>

namespace keypose::synth {

/// Makes a folder for numbered pictures (IMG_0001.jpg, 0001.png), and takes out those that an
/// earlier command has left there: they show another world, or are more than are made now.
///
/// @param made_here  a folder that synth makes beside it; where it is missing, pictures in the
/// folder are somebody's own
/// @throws UsageError  the folder has pictures that synth did not make
/// @throws DiskError   it cannot be made, or cleared
void MakeFreshFolder(const std::filesystem::path& folder, const std::filesystem::path& made_here);

}  // namespace keypose::synth
