// Parts of projects that several walks make.

/**
 * A stage as a shell script, which tells of itself by NAME.json beside it. `act` has its folder in
 * $here, the path that it makes in $to, its report's in $report, and $figure as it was given.
 * @param output  the flag of what it makes, without --
 */
export const stageScript = (name, output, act) => `#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
if [ "$1" = --describe ]; then
  cat "$here/${name}.json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --${output}) to=$2 ;;
    --report) report=$2 ;;
    --figure) figure=$2 ;;
  esac
  shift 2
done
${act}`;

/** Two poses and a film: the true surfaces stand for scans, which other tests make. */
export function filmedProject(comment) {
  const off = 'capture sfm masks dense mesh refine cleanup bake complete export report'.split(' ');
  return `${comment}
name: dance
poses: {rest: photos/rest, wave: photos/wave}
template: rest
steps:
${off.map((step) => `  ${step}: {enabled: false}`).join('\n')}
  unwrap: {inputs: {clean: ./meshes/rest.ply}}
  register: {inputs: {target: ./meshes/wave.ply}}
  locate: {inputs: {textures: null}}
  composite: {inputs: {textures: ./texture.png}}
`;
}
