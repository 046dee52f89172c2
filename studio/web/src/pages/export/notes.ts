// What the last export wrote: sizes and errors of the formats, from its animation.json.
import { useEffect, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import type { Note, Result } from './formats'
import { linkTo } from './results'

/** The formats in an animation.json; those of a file that is no such are none. */
export function notesOf(summary: unknown): Note[] {
  const formats = (summary as { formats?: unknown } | null)?.formats
  if (!Array.isArray(formats)) return []
  return formats.filter(
    (one): one is Note => typeof one?.format === 'string' && typeof one?.bytes === 'number',
  )
}

export function useNotes(results: Result[]): Note[] {
  const { version } = useStudio()
  const [notes, setNotes] = useState<Note[]>([])
  const path = results.find((one) => /(^|\/)animation\.json$/.test(one.path))?.path
  useEffect(() => {
    let alive = true
    const load = async () => (path ? (await fetch(linkTo(path))).json() : null)
    load()
      .then((summary) => alive && setNotes(notesOf(summary)))
      // It is being replaced by a run: its end loads it again.
      .catch(() => undefined)
    return () => {
      alive = false
    }
  }, [path, version])
  return notes
}
