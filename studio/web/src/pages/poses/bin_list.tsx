// What was deleted on these pages, and the way back.
import { useRef } from 'preact/hooks'

import { api } from '../../api'
import type { BinEntry } from '../../api'
import { Picture } from '../../picture'
import { useStudio } from '../../state'
import { count } from '../../words'
import { useLoaded } from './load'

const kShown = 4
const isPicture = (file: string) =>
  /\.(jpe?g|jfif|png|tiff?|hei[cf]|hif)$/i.test(file) && file.startsWith('photos/')

function wordsOf(entry: BinEntry): string {
  if (entry.what === 'pose') return `The pose ${entry.pose}`
  if (entry.what !== 'photographs') return count(entry.files.length, 'file')
  const [first] = entry.names
  return entry.names.length === 1 ? first : `${count(entry.names.length, 'photograph')}`
}

function Row({ entry, back }: { entry: BinEntry; back: () => void }) {
  return (
    <li>
      <span class="row">
        {entry.files
          .filter(isPicture)
          .slice(0, kShown)
          .map((file) => (
            <Picture key={file} src={api.binUrl(entry.id, file, 160)} alt="" loading="lazy" />
          ))}
      </span>
      <span>
        <b>{wordsOf(entry)}</b>
        <span class="small soft">
          {entry.what === 'pose'
            ? 'its photographs, landmarks and masks; its keys on a timeline with times are set anew'
            : `of ${entry.pose}`}
        </span>
      </span>
      <button onClick={back}>Take back</button>
    </li>
  )
}

/** A button with the number of entries; nothing while the bin is empty. */
export function BinList() {
  const { version, tell, complain, reload } = useStudio()
  const bin = useLoaded(() => api.bin(), [version])
  const dialog = useRef<HTMLDialogElement>(null)
  const entries = bin.value ?? []
  const back = async (entry: BinEntry) => {
    try {
      await api.takeBack(entry.id)
      tell(`Taken back: ${wordsOf(entry)}.`)
      if (entries.length === 1) dialog.current!.close()
      await reload()
    } catch (error) {
      dialog.current!.close() // the reason is told below it
      complain(error)
    }
  }
  if (entries.length === 0) return null
  return (
    <>
      <button class="quiet small" onClick={() => dialog.current!.showModal()}>
        Bin <span class="number soft">{entries.length}</span>
      </button>
      <dialog ref={dialog} class="photo-dialog" aria-labelledby="bin-title">
        <form method="dialog" class="row spread">
          <h2 id="bin-title">The bin</h2>
          <button>Close</button>
        </form>
        <p class="small soft">
          The project’s folder <code>bin</code>. It is never emptied by itself.
        </p>
        <ul class="bin" tabIndex={0} aria-label="Deleted">
          {entries.map((entry) => (
            <Row key={entry.id} entry={entry} back={() => void back(entry)} />
          ))}
        </ul>
      </dialog>
    </>
  )
}
