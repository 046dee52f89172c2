// The player's section of the page: poster, controls, data, script.
#include "report/html/html.h"
#include "report/page/sections.h"
#include "report/player/player_data.h"

namespace keypose::report {
namespace {

std::string Box(const char* control, const char* label, bool checked) {
  return "<label><input type=checkbox data-control=" + std::string(control) +
         (checked ? " checked" : "") + "> " + label + "</label>";
}

std::string Controls(const PlayerPart& player) {
  std::string html = "<div class=controls hidden>";
  if (player.pictures > 1) {
    html +=
        "<button type=button data-control=play>Play</button><input type=range data-control=scrub "
        "aria-label=\"time\" min=0 max=" +
        std::to_string(player.pictures - 1) +
        " value=0><span data-control=time class=time></span><label>speed <select "
        "data-control=speed>";
    for (const char* speed : {"0.25", "0.5", "1", "2"})
      html += "<option value=" + std::string(speed) +
              (std::string(speed) == "1" ? " selected" : "") + ">" + speed + "\u00d7</option>";
    html += "</select></label>";
  }
  html += Box("turn", "turn", true);
  if (player.textured) html += Box("texture", "texture", true);
  html += Box("edges", "edges", false);
  if (player.keys > 1) html += Box("skins", "keys as onion skin", false);
  return html + "</div>";
}

}  // namespace

std::string PlayerSection(const Contents& contents, const Encoder& encode) {
  if (!contents.player) return "";
  const PlayerPart& player = *contents.player;
  if (player.json.empty())
    return "<section id=player><h2>The animation</h2><p class=lead>The mesh is too large to play "
           "within the page: open "
           "<code>out/animation/character.glb</code> in Blender or any glTF "
           "viewer.</p></section>\n";
  std::string html = "<section id=player data-state=poster><h2>" +
                     std::string(player.pictures > 1 ? "The animation" : "The figure") +
                     "</h2><div class=stage>";
  if (player.poster) html += Image(encode(player.poster->image), player.poster->caption);
  html += "</div>" + Controls(player) +
          "<p class=lead>Drag to turn, scroll to come closer, right button to move.";
  if (player.stored < player.distinct)
    html += " To keep the page small it holds " + Pretty(player.stored) + " of " +
            Pretty(player.distinct) +
            " frames and goes straight between them; the exported files hold all.";
  return html + "</p></section>\n";
}

std::string PlayerProgram(const Contents& contents) {
  if (!contents.player || contents.player->json.empty()) return "";
  return "<script type=\"application/json\" id=player-data>" + contents.player->json +
         "</script>\n<script>" + PlayerScript() + "</script>\n";
}

}  // namespace keypose::report
