// A take that is opened: its character once, then each draft; changes that are not kept yet stay in
// this browser.
import { useCallback, useEffect, useState } from 'preact/hooks'

import { ApiError } from '../../api'
import { useStudio } from '../../state'
import { sentence } from '../../words'
import { loadCharacter } from '../armature/use_character'
import type { Loaded } from '../armature/use_character'
import { Edits } from './edits'
import type { Change } from './edits'
import { takeApi } from './take_api'

export interface Opened {
  loaded: Loaded
  hasSet: boolean
  edits: Edits
}

const kEdits = 'keypose take '
const kNoFit =
  'Changes that were kept in this browser do not fit the take any more, and are left out.'
/** A studio that is away is asked again after this time. */
const kAskAgain_ms = 1500

function storedEdits(key: string): Change[] {
  try {
    const stored: unknown = JSON.parse(localStorage.getItem(kEdits + key) ?? '[]')
    if (!Array.isArray(stored)) return []
    return stored.filter(
      (one): one is Change => Array.isArray(one) && one.every((line) => typeof line === 'string'),
    )
  } catch {
    return []
  }
}

function store(key: string, done: Change[]): void {
  if (done.length > 0) localStorage.setItem(kEdits + key, JSON.stringify(done))
  else localStorage.removeItem(kEdits + key)
}

export interface UsedTake {
  opened: Opened | null
  /** why the take cannot be shown, or '' */
  failure: string
  /** Opens it anew: its files are others now. */
  again: () => void
}

/** Drawn again whenever the edits have changed. */
export function useTake(name: string): UsedTake {
  const { project, complain } = useStudio()
  const [opened, setOpened] = useState<Opened | null>(null)
  const [failure, setFailure] = useState('')
  const [, drawAgain] = useState(0)
  const [attempt, setAttempt] = useState(0)
  const key = `${project.folder} ${name}`
  useEffect(() => {
    let ended = false
    const open = async () => {
      const answer = await takeApi.open(name)
      const character = await loadCharacter(answer, name)
      if (ended) return
      let trouble = ''
      const edits: Edits = new Edits({
        draft: (lines, between) => takeApi.draft(name, lines, between, answer.view.bones),
        changed: () => {
          if (ended) return
          if (edits.draft) store(key, edits.done)
          if (edits.draft && trouble) complain(new Error(`${kNoFit} ${sentence(trouble)}`))
          if (edits.draft) trouble = ''
          if (trouble && !edits.busy) setFailure(trouble)
          drawAgain((old) => old + 1)
        },
        refused: (error) => {
          const words = error instanceof Error ? error.message : String(error)
          if (edits.draft) complain(new Error(sentence(words)))
          else trouble = words
        },
        again: async (error) => {
          if (ended || !(error instanceof ApiError) || error.status !== 0) return false
          complain(error)
          await new Promise((go) => setTimeout(go, kAskAgain_ms))
          return !ended
        },
      })
      setOpened({ loaded: { view: answer.view, character }, hasSet: answer.set, edits })
      edits.begin(storedEdits(key))
    }
    open().catch((error: unknown) => {
      if (!ended) setFailure(error instanceof Error ? error.message : String(error))
    })
    return () => {
      ended = true
    }
  }, [name, key, attempt, complain])
  const again = useCallback(() => {
    setOpened(null)
    setFailure('')
    setAttempt((old) => old + 1)
  }, [])
  return { opened, failure, again }
}
