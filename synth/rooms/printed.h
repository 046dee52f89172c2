// Prints of printed matter: turntable mats, books, pictures on walls, labels, toy blocks.
#pragma once

#include "synth/rooms/print.h"

namespace keypose::synth {

/// A mat to turn a figure on, to scale: a circle with ticks and numbers, crosses, bars of 1 cm,
/// squared paper over a map in the middle, a row of words. Its middle is the sheet's.
Print MatPrint(double side_m, PrintRandom random);
/// The front of a book or magazine: a picture, title, blocks of lines.
Print CoverPrint(double width_m, double height_m, PrintRandom random);
/// The back edge of a book, upright: a title that runs down, bands, a sign.
Print SpinePrint(double width_m, double height_m, PrintRandom random);
/// The edges of a book's pages.
Print PagesPrint(double width_m, double height_m, PrintRandom random);
/// A framed painting: washes of colour, hills, shapes.
Print PaintingPrint(double width_m, double height_m, PrintRandom random);
/// A calendar or poster: words, figures in boxes.
Print PosterPrint(double width_m, double height_m, PrintRandom random);
/// What is printed around a box, tin or mug: bands, words, shapes.
Print LabelPrint(double width_m, double height_m, PrintRandom random);
/// One painted wooden side of a toy block, with a letter.
Print BlockPrint(double side_m, PrintRandom random);
/// Even paint with fine grain.
Print PaintPrint(double width_m, double height_m, PrintRandom random);

}  // namespace keypose::synth
