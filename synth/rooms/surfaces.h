// Prints of large surfaces: cloth, wood, walls, carpets, bricks, bark, leaves.
#pragma once

#include "synth/rooms/print.h"

namespace keypose::synth {

/// A table-cloth: checks, dots, flowers or stripes on woven threads, with folds and a few stains.
Print ClothPrint(double width_m, double height_m, PrintRandom random);
/// Boards with their grain.
Print BoardsPrint(double width_m, double height_m, double board_m, PrintRandom random);
/// Wall-paper with a motif, or rough plaster.
Print WallPrint(double width_m, double height_m, PrintRandom random);
/// A carpet's pile with a border and figures.
Print CarpetPrint(double width_m, double height_m, PrintRandom random);
/// Courses of bricks or of hewn stones, with mortar.
Print MasonryPrint(double width_m, double height_m, PrintRandom random);
/// Bark of an old tree; repeats to the right.
Print BarkPrint(double width_m, double height_m, double pixels_per_m, PrintRandom random);
/// The floor of a wood: fallen leaves, needles, soil.
Print LeavesPrint(double width_m, double height_m, PrintRandom random);
/// Foliage and sky behind the trees of a wood.
Print FoliagePrint(double width_m, double height_m, PrintRandom random);

}  // namespace keypose::synth
