// The camera of a frame at once: asked for by its clicks alone whenever they change, and drawn over
// the frame. It is rough; the whole work is the step `locate`.
import { useEffect, useRef, useState } from 'preact/hooks'

import { shotApi } from './shot_api'
import type { Film, Quick } from './shot_api'
import type { ShotDesk } from './use_shot'
import { quickWords } from './words'

/** Clicks that place a mesh. */
const kEnough = 4

export interface QuickCamera {
  on: boolean
  toggle: () => void
  /** '' until there is one */
  picture: string
  /** what it has given, or why it has not; '' before */
  words: string
  bad: boolean
  busy: boolean
}

/** Asks once what is asked for now, and again if it has changed meanwhile. */
export function useQuick(
  desk: ShotDesk,
  film: Film,
  frame: number,
  clicks: number,
): QuickCamera {
  const { clicks: file, shot } = desk
  const [on, setOn] = useState(true)
  const [answer, setAnswer] = useState<{ of: string; quick: Quick } | null>(null)
  const [asking, setAsking] = useState('')
  const pose = film.shows.find((show) => show.frame === frame)?.pose ?? ''
  // With the file's revision only what is saved is asked for.
  const ready = on && pose !== '' && clicks >= kEnough && !file.saving && !file.failed
  const key = `${frame} ${pose} ${shot?.clicks?.revision} ${film.mattes} ${film.film}`
  const wanted = useRef('')
  wanted.current = ready ? key : ''
  useEffect(() => {
    if (!ready || asking !== '' || answer?.of === key) return
    setAsking(key)
    shotApi
      .quick(frame)
      .catch((error: Error): Quick => {
        return { frame, number: -1, seconds: 0, problem: error.message }
      })
      .then((quick) => {
        setAsking('')
        if (wanted.current === key || wanted.current === '') setAnswer({ of: key, quick })
      })
  }, [ready, key, asking, answer])
  const shown = on && clicks >= kEnough && answer?.quick.frame === frame ? answer.quick : null
  const there = shown !== null && shown.problem === ''
  return {
    on,
    toggle: () => setOn(!on),
    picture: there ? shotApi.pictureUrl('quick', shown.number, 0, answer!.of) : '',
    words: shown ? quickWords(shown) : '',
    bad: shown !== null && !there,
    busy: asking !== '',
  }
}

/** Below the frame: what to do next, what the clicks give, and the switch for it. */
export function QuickLine({ quick, hint }: { quick: QuickCamera; hint: string }) {
  return (
    <div class="shot-hint small row">
      <p role="status">
        {hint} {quick.on && quick.words && <b class={quick.bad ? 'bad' : ''}>{quick.words}</b>}
      </p>
      <span class="shot-gap" />
      <button
        aria-pressed={quick.on}
        aria-busy={quick.busy}
        title="With four clicks in a frame: the mesh’s outlines over it, at once and roughly (O)"
        onClick={quick.toggle}
      >
        Outlines at once
      </button>
    </div>
  )
}
