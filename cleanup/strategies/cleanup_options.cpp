#include "cleanup/strategies/cleanup_options.h"

namespace keypose::cleanup {

void CleanupOptions::Describe(OptionVisitor& visit) {
  visit("faces", faces,
        {.help = "wanted number of faces; surfaces with more are remeshed to it within 1 %",
         .unit = "faces",
         .min = 100,
         .max = 5000000});
  visit("refine", refine,
        {.help = "also remesh surfaces that have fewer faces than wanted", .unit = ""});
  visit("remesh", remesh,
        {.help = "more triangles where the surface bends, or equal ones",
         .unit = "",
         .choices = {"adaptive", "uniform"}});
  visit("genus", genus,
        {.help = "handles that the result has; surplus ones are cut or filled, and fewer are an "
                 "error; -1 keeps all; -2 keeps those that "
                 "the photographs see through, none without photographs",
         .unit = "",
         .min = -2,
         .max = 1000});
  visit("support", support,
        {.help = "auto cuts off a level turntable, base or cloth that the figure stands on (z "
                 "up); keep leaves it",
         .unit = "",
         .choices = {"auto", "keep"}});
  visit("ground", ground,
        {.help = "auto cuts soles flat at z = 0 where the figure stands on it; keep leaves them",
         .unit = "",
         .choices = {"auto", "keep"}});
  visit("keep_components", keep_components,
        {.help = "pieces of the result, largest first; 0 keeps all",
         .unit = "pieces",
         .min = 0,
         .max = 1000000});
  visit("min_component", min_component,
        {.help = "pieces with less than this share of the largest one's area are dropped",
         .unit = "",
         .min = 0,
         .max = 1});
  visit("wrap", wrap, {.help = "allow an alpha wrap when local repair fails", .unit = ""});
  visit("wrap_alpha", wrap_alpha,
        {.help = "alpha of the wrap over the diagonal; 0 chooses it from faces",
         .unit = "",
         .min = 0,
         .max = 0.2});
  visit("drop_layout", drop_layout,
        {.help = "texture coordinates of the surface go without a warning: `bake` carries the "
                 "colours over, or they are not wanted",
         .unit = ""});
}

}  // namespace keypose::cleanup
