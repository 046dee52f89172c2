// Loads the shot whenever the project changes, and keeps its clicks.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { useUnsavedGuard } from '../poses/route'
import { ClickFile } from './click_file'
import { shotApi } from './shot_api'
import type { Shot, ShotChange } from './shot_api'

/** What to write, from what the file then has. */
type Change = (now: Shot) => ShotChange

export interface ShotDesk {
  /** null: not read yet */
  shot: Shot | null
  clicks: ClickFile
  /** Writes what the shot consists of to pipeline.yaml; false: it was refused, and that was told. */
  save: (change: Change) => Promise<boolean>
  saving: boolean
}

export function useShot(): ShotDesk {
  const { version, tell, complain } = useStudio()
  const [shot, setShot] = useState<Shot | null>(null)
  const [saving, setSaving] = useState(false)
  const [, drawAgain] = useState(0)
  const latest = useRef<Shot | null>(null)
  const chain = useRef<Promise<unknown>>(Promise.resolve())
  const clicks = useMemo(() => {
    const store = {
      save: async (list: ClickFile['clicks'], revision: string) => {
        const now = await shotApi.saveClicks(list, revision)
        latest.current = now
        setShot(now)
        return now.clicks?.revision ?? ''
      },
      read: async () => (await shotApi.shot()).clicks ?? { clicks: [], revision: '' },
    }
    return new ClickFile(store, () => drawAgain((old) => old + 1), tell)
  }, [tell])
  const take = (now: Shot, asked?: number) => {
    latest.current = now
    setShot(now)
    if (now.clicks) clicks.take(now.clicks.clicks, now.clicks.revision, asked)
  }
  useEffect(() => {
    let current = true
    const asked = clicks.moment
    shotApi.shot().then(
      (now) => {
        if (current) take(now, asked)
        // A click that could not be saved, perhaps as the studio was away, is tried again.
        if (current && clicks.failed) void clicks.save()
      },
      (error: unknown) => current && complain(error),
    )
    return () => {
      current = false
    }
  }, [version, clicks, complain])
  useUnsavedGuard(clicks.failed !== '')
  // One after the other: each begins with the file that the one before has made.
  const save = (change: Change) => {
    setSaving(true)
    const next: Promise<boolean> = chain.current
      .then(() => shotApi.save({ ...change(latest.current!), revision: latest.current!.revision }))
      .then((now) => {
        take(now)
        return true
      })
      .catch(async (error: unknown) => {
        complain(error)
        await shotApi.shot().then((now) => take(now)).catch(complain)
        return false
      })
      .finally(() => chain.current === next && setSaving(false))
    chain.current = next
    return next
  }
  return { shot, clicks, save, saving }
}
