// The files that the project has made, by folder; numbered frames are folded into one line.
import { api } from '../../api'
import { useStudio } from '../../state'
import { bytes } from '../../words'
import { Icon } from '../run/icons'
import { sizeOf } from './formats'
import type { Result } from './formats'

/** A path's parts may hold any letter; the slashes between them stay. */
export const linkTo = (path: string): string =>
  `/results/${path.split('/').map(encodeURIComponent).join('/')}`

const folderOf = (path: string): string => path.split('/').slice(0, -1).join('/')
const nameOf = (path: string): string => path.split('/').pop() ?? path

/** Folders in the order of their first file. */
export function byFolder(results: Result[]): [string, Result[]][] {
  const folders = new Map<string, Result[]>()
  for (const one of results) {
    const folder = folderOf(one.path)
    folders.set(folder, [...(folders.get(folder) ?? []), one])
  }
  return [...folders]
}

function FileLine({ file }: { file: Result }) {
  return (
    <li>
      <a href={linkTo(file.path)} download={nameOf(file.path)} title={`Download ${file.path}`}>
        <span class="name">{nameOf(file.path)}</span>
        {file.label && file.label !== nameOf(file.path) && (
          <small class="soft">{file.label}</small>
        )}
      </a>
      <small class="soft number">{bytes(file.bytes)}</small>
    </li>
  )
}

const kFolded = 8

function Folder({ folder, files }: { folder: string; files: Result[] }) {
  const { tell, complain } = useStudio()
  const reveal = () =>
    api
      .reveal(folder)
      .then(({ shown }) => shown || tell('This desktop has no file manager that answers.'))
      .catch(complain)
  const list = (
    <ul>
      {files.map((file) => (
        <FileLine key={file.path} file={file} />
      ))}
    </ul>
  )
  return (
    <section class="export-folder">
      <header>
        <code title={folder}>{folder || 'results'}</code>
        <button class="quiet" onClick={() => void reveal()} aria-label={`Reveal folder ${folder}`}>
          <Icon name="folder" /> Reveal
        </button>
      </header>
      {files.length <= kFolded ? (
        list
      ) : (
        <details>
          <summary>
            {files.length} files
            <small class="soft number">{bytes(sizeOf(files))}</small>
          </summary>
          {list}
        </details>
      )}
    </section>
  )
}

export function Results({ results }: { results: Result[] }) {
  return (
    <section class="export-results" aria-label="Results">
      <h2>Results</h2>
      {results.length === 0 && <p class="soft">Nothing made yet: press Run, at the top right.</p>}
      {byFolder(results).map(([folder, files]) => (
        <Folder key={folder} folder={folder} files={files} />
      ))}
    </section>
  )
}
