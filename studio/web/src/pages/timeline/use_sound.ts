// The page's one sound: chosen once, found again in this browser.
import { useCallback, useEffect, useMemo, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { keepSound, keptSound, Sound } from './sound'

export interface SoundState {
  sound: Sound
  /** changes with the sound, for what draws it */
  stamp: number
  choose: (file: File) => void
  remove: () => void
  setOn: (on: boolean) => void
  setOffset: (seconds: number) => void
}

export function useSound(): SoundState {
  const { project, tell, complain } = useStudio()
  const sound = useMemo(() => new Sound(), [])
  const [stamp, setStamp] = useState(0)
  const [file, setFile] = useState<Blob | null>(null)
  const changed = useCallback(() => setStamp((old) => old + 1), [])

  useEffect(() => {
    let current = true
    const load = async () => {
      const kept = await keptSound(project.folder)
      if (!kept || !current) return
      await sound.load(kept.file, kept.name)
      sound.offset = kept.offset
      setFile(kept.file)
      changed()
    }
    // A private window keeps nothing; the page works without.
    load().catch(() => undefined)
    return () => {
      current = false
      sound.dispose()
    }
  }, [project.folder, sound, changed])

  const keep = (blob: Blob | null) =>
    keepSound(
      project.folder,
      blob && { name: sound.name, file: blob, offset: sound.offset },
    ).catch(() => tell('This browser keeps no files: choose the sound again next time.'))

  return {
    sound,
    stamp,
    choose: (chosen) => {
      sound.load(chosen, chosen.name).then(() => {
        sound.offset = 0
        sound.on = true
        setFile(chosen)
        changed()
        void keep(chosen)
      }, complain)
    },
    remove: () => {
      sound.clear()
      setFile(null)
      changed()
      void keep(null)
    },
    setOn: (on) => {
      sound.on = on
      if (!on) sound.stop()
      changed()
    },
    setOffset: (seconds) => {
      sound.offset = seconds
      changed()
      void keep(file)
    },
  }
}
