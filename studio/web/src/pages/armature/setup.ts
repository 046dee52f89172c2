// What a session needs to know before it begins, as the form holds it.
import type { ArmatureSetup } from './armature_api'

export const kSimulated = 'simulated'

export const kFirstSetup: ArmatureSetup = {
  take: 'take1',
  port: kSimulated,
  calibration: 'armature/puppet.json',
  description: '',
  chains: '',
  skeleton: '',
  mesh: '',
  weights: '',
  texture: '',
  plate: '',
  shot: '',
  set: '',
  armature_up: 'z',
  skeleton_up: 'z',
  fps: 24,
  step: 2,
}

/** The page on which a take is edited. */
export const addressOfTake = (take: string): string => `#/armature/${encodeURIComponent(take)}`

/** The take that an address names, or ''. */
export function takeOfAddress(hash: string): string {
  try {
    return decodeURIComponent(hash.replace(/^#\/?/, '').split('/')[1] ?? '')
  } catch {
    return ''
  }
}

export interface FileField {
  name: keyof ArmatureSetup & string
  label: string
  /** endings of the files that are offered */
  kinds: RegExp
  hint: string
}

export const kNeeded: FileField[] = [
  { name: 'description', label: 'Description', kinds: /\.txt$/i, hint: 'The tree of joints.' },
  { name: 'chains', label: 'Chains', kinds: /\.txt$/i, hint: 'Anchors and chains.' },
]
export const kOptional: FileField[] = [
  { name: 'skeleton', label: 'Skeleton', kinds: /\.bvh$/i, hint: 'Else like the armature.' },
  {
    name: 'mesh',
    label: 'Character',
    kinds: /\.(ply|obj|off|stl)$/i,
    hint: 'Else ball and stick.',
  },
  {
    name: 'weights',
    label: 'Weights',
    kinds: /\.(json|mhw|dmat)$/i,
    hint: 'Else computed by heat.',
  },
  { name: 'texture', label: 'Texture', kinds: /\.(png|jpe?g)$/i, hint: '' },
  { name: 'plate', label: 'Plate', kinds: /\.(png|jpe?g)$/i, hint: 'A picture, or a folder.' },
  { name: 'shot', label: 'Camera', kinds: /\.json$/i, hint: 'shot.json, as locate writes it.' },
  { name: 'set', label: 'Set', kinds: /\.(ply|obj|off|stl)$/i, hint: 'Table, lamp: as of glass.' },
]

/** What is wrong with a field, by its name; empty: it can begin. */
export function problemsOf(setup: ArmatureSetup): Partial<Record<keyof ArmatureSetup, string>> {
  const problems: Partial<Record<keyof ArmatureSetup, string>> = {}
  if (!/^[\p{L}\p{M}\p{N}_][\p{L}\p{M}\p{N}_-]*$/u.test(setup.take))
    problems.take = setup.take ? 'Letters, digits, - and _ only.' : 'Name the take.'
  if (!setup.description) problems.description = 'Which file describes the armature?'
  if (!setup.chains) problems.chains = 'Which file has anchors and chains?'
  if (setup.port !== kSimulated && !setup.port.startsWith('/dev/'))
    problems.port = 'On which port is the controller?'
  if (setup.port !== kSimulated && !setup.calibration)
    problems.calibration = 'Calibrate makes it: name the file.'
  if (!(setup.fps >= 1 && setup.fps <= 1000)) problems.fps = 'A number from 1 to 1000.'
  return problems
}
