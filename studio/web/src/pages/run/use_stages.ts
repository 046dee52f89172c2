// The stages with their options, asked once for all pages: they change only with the program.
import { useEffect, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Stage, StageOption } from '../../api'
import { useStudio } from '../../state'

/** `common` comes with --describe: options that people do change, to be shown first. */
export type KnownOption = StageOption & { common?: boolean }

let asked: Promise<Stage[]> | null = null

export function useStages(): Stage[] | null {
  const { complain } = useStudio()
  const [stages, setStages] = useState<Stage[] | null>(null)
  useEffect(() => {
    let alive = true
    asked ??= api.stages()
    asked
      .then((all) => alive && setStages(all))
      .catch((error) => {
        asked = null // the next page asks again
        if (alive) complain(error)
      })
    return () => {
      alive = false
    }
  }, [complain])
  return stages
}
