// What runs again when photographs of a pose change, in words.
import type { Again, Step } from '../../api'
import { count, duration, stepName } from '../../words'

const kShort = 1 // [s]: not worth a word

/** Said before a change is made. */
export function againWords(again: Again | null, pose: string, steps: Step[]): string {
  if (!again) return ''
  if (!again.step) return 'No step reads the photographs of this pose.'
  if (!again.made) return `Nothing is made of ${pose} yet: the next run begins with it.`
  const after = count(again.follow.length, 'step')
  const time = again.seconds > kShort ? `; all of it took ${duration(again.seconds)} last time` : ''
  return `The next run makes “${stepName(again.step, steps)}” again, and after it up to ${after}${time}.`
}
