// What is wrong with a photograph, as small marks.
import type { Judged } from './quality'

/** `words`: with the reason beside the mark; otherwise it is in the tool tip. */
export function Flags({ judged, words = false }: { judged: Judged; words?: boolean }) {
  return (
    <>
      {judged.flags.map((flag) => (
        <span key={flag.text} class={`${words ? 'said' : 'flag'} ${flag.grade}`} title={flag.why}>
          {words ? flag.why : flag.text}
        </span>
      ))}
    </>
  )
}
