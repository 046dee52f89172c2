// Landmark files of other programs: in by a dialog or by dropping, out by links.
import { useRef, useState } from 'preact/hooks'
import type { ComponentChildren } from 'preact'

import { api } from '../../api'
import { useStudio } from '../../state'
import { count } from '../../words'
import type { PickFiles } from './pick_files'

const kFormats = [
  { format: 'pp', name: 'MeshLab', ending: '.pp' },
  { format: 'wrap', name: 'Faceform Wrap', ending: '.txt' },
  { format: 'json', name: 'Keypose', ending: '.json' },
] as const
/** More than any landmark file has; stops a photograph that was dropped by mistake. */
const kLargest_bytes = 4e6

export function useImport(files: PickFiles) {
  const { tell, complain } = useStudio()
  return async (pose: string, file: File | undefined) => {
    if (!file) return
    try {
      if (file.size > kLargest_bytes)
        throw new Error(`${file.name} is too large for a file of landmarks.`)
      await files.save()
      const read = await api.importPicks(pose, file.name, await file.text())
      files.imported(`import ${file.name}`, { ...read, pose })
      tell(`${pose} has ${count(read.picks.length, 'landmark')} from ${file.name}.`)
    } catch (error) {
      complain(error)
    }
  }
}

export function FilesMenu(props: {
  pose: string
  empty: boolean
  take: (file: File | undefined) => void
}) {
  const { pose } = props
  const choose = useRef<HTMLInputElement>(null)
  return (
    <details
      class="lm-menu"
      onKeyDown={(event) => {
        if (event.key !== 'Escape') return
        event.currentTarget.open = false
        event.currentTarget.querySelector('summary')?.focus()
        event.stopPropagation()
      }}
      onFocusOut={(event) => {
        const next = event.relatedTarget as Node | null
        if (next && !event.currentTarget.contains(next)) event.currentTarget.open = false
      }}
    >
      <summary aria-label={`Landmark files of ${pose}`}>Files</summary>
      <div>
        <button class="quiet" onClick={() => choose.current?.click()}>
          Import… <span class="soft">.pp .txt .json</span>
        </button>
        <input
          ref={choose}
          type="file"
          class="hidden"
          tabIndex={-1}
          aria-label={`Import landmarks of ${pose}`}
          accept=".pp,.txt,.json"
          onChange={(event) => {
            props.take(event.currentTarget.files?.[0])
            event.currentTarget.value = ''
          }}
        />
        {!props.empty &&
          kFormats.map(({ format, name, ending }) => (
            <a
              key={format}
              class="button quiet"
              href={api.exportPicksUrl(pose, format)}
              download={`${pose}${ending}`}
            >
              Export for {name} <span class="soft">{ending}</span>
            </a>
          ))}
      </div>
    </details>
  )
}

/** Takes a file that is dropped on a view, and says so while it hovers. */
export function DropPlace(props: {
  label: string
  take: (file: File | undefined) => void
  children: ComponentChildren
}) {
  const [over, setOver] = useState(false)
  return (
    <div
      class={over ? 'lm-drop over' : 'lm-drop'}
      onDragOver={(event) => {
        if (!event.dataTransfer?.types.includes('Files')) return
        event.preventDefault()
        setOver(true)
      }}
      onDragLeave={(event) => {
        if (!event.currentTarget.contains(event.relatedTarget as Node | null)) setOver(false)
      }}
      onDrop={(event) => {
        event.preventDefault()
        setOver(false)
        props.take(event.dataTransfer?.files[0])
      }}
    >
      {props.children}
      {over && <div class="lm-dropwords">{props.label}</div>}
    </div>
  )
}
