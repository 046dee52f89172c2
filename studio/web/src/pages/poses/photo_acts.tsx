// What can be done to photographs of a pose: by menu, by key, from a warning.
import { useRef } from 'preact/hooks'

import { api } from '../../api'
import { useStudio } from '../../state'
import { count } from '../../words'
import { againWords } from './again_words'
import { useLoaded } from './load'

export interface PhotoActs {
  /** what runs again after any of it */
  note: string
  leaveOut: (names: string[], out: boolean) => void
  remove: (names: string[]) => void
  /** Asks for the file that takes the place of a photograph. */
  replace: (name: string) => void
  /** an element that must be on the page */
  chooser: preact.JSX.Element
}

const kAccept = '.jpg,.jpeg,.jfif,.png,.tif,.tiff,.heic,.heif,.hif'

export function usePhotoActs(pose: string): PhotoActs {
  const { steps, tell, complain, reload, version } = useStudio()
  const again = useLoaded(() => api.again(pose), [pose, version])
  const input = useRef<HTMLInputElement>(null)
  const replaced = useRef('')
  const act = async (change: () => Promise<unknown>, words: string) => {
    try {
      await change()
      tell(words)
      await reload()
    } catch (error) {
      complain(error)
    }
  }
  const called = (names: string[]) =>
    names.length === 1 ? names[0] : count(names.length, 'photograph')
  const is = (names: string[]) => (names.length === 1 ? 'is' : 'are')
  return {
    note: againWords(again.value, pose, steps.steps),
    leaveOut: (names, out) =>
      void act(
        () => api.leaveOut(pose, names, out),
        `${called(names)} ${is(names)} ${out ? 'left out' : 'taken back'}. Press Run when you are ready.`,
      ),
    remove: (names) =>
      void act(
        () => api.deletePhotographs(pose, names),
        `${called(names)} ${is(names)} in the bin, below the list of poses.`,
      ),
    replace: (name) => {
      replaced.current = name
      input.current!.click()
    },
    chooser: (
      <input
        ref={input}
        type="file"
        hidden
        aria-label="The photograph that takes its place"
        accept={kAccept}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0]
          event.currentTarget.value = ''
          const old = replaced.current
          if (file)
            void act(
              () => api.addPhotograph(pose, file.name, file, old),
              `${file.name} takes the place of ${old}, which is in the bin.`,
            )
        }}
      />
    ),
  }
}
