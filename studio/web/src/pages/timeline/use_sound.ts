// The project's sound, as the timeline hears and changes it.
import { useCallback, useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api, type ProjectSound } from '../../api'
import { useStudio } from '../../state'
import { Sound } from './sound'

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
  const loaded = useRef('')
  const changed = useCallback(() => setStamp((old) => old + 1), [])

  const take = useCallback(
    async (now: ProjectSound | null, bytes: Blob | null, current: () => boolean) => {
      if (!now) {
        loaded.current = ''
        sound.clear()
      } else {
        if (loaded.current !== now.file || bytes) {
          const blob = bytes ?? (await api.soundBytes(now.file))
          if (!current()) return
          await sound.load(blob, now.name)
          loaded.current = now.file
        }
        sound.offset = now.at
      }
      changed()
    },
    [sound, changed],
  )

  // Also after somebody has edited pipeline.yaml.
  useEffect(() => {
    let current = true
    api
      .sound()
      .then((now) => (current ? take(now, null, () => current) : undefined))
      .catch(complain)
    return () => {
      current = false
    }
  }, [project.folder, project.revision, take, complain])
  useEffect(() => () => sound.dispose(), [sound])

  const choose = async (file: File) => {
    // Checked here first: what this browser cannot play, nobody could time against.
    await sound.load(file, file.name)
    const now = await api.saveSound(file.name, file)
    sound.on = true
    await take(now, file, () => true)
    tell(`${now.file} is the project's sound now: its films carry it after the next run.`)
  }
  return {
    sound,
    stamp,
    choose: (file) => {
      choose(file).catch((error) => {
        complain(error)
        sound.clear()
        loaded.current = ''
        api.sound().then((now) => take(now, null, () => true), complain)
      })
    },
    remove: () => {
      api.removeSound().then((now) => {
        tell('The project has no sound now; its file stays in the folder.')
        return take(now, null, () => true)
      }, complain)
    },
    setOn: (on) => {
      sound.on = on
      if (!on) sound.stop()
      changed()
    },
    setOffset: (seconds) => {
      sound.offset = seconds
      changed()
      api.moveSound(seconds).catch(complain)
    },
  }
}
