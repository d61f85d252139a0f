// The bus access layer. Source: VCI V3 .NET manual 4.1; the vendor's published contract of Ixxat.Vci4.
using System;
using System.Collections;

#if VCI3
namespace Ixxat.Vci3.Bal
#else
namespace Ixxat.Vci4.Bal
#endif
{
    /// <summary>The connectors of a board; what was opened from it outlives it.</summary>
    public interface IBalObject : IDisposable
    {
        Version FirmwareVersion { get; }

        BalResourceCollection Resources { get; }

        /// <summary>
        /// An interface (typeof(ICanChannel)) of a connector, counted from 0. Throws ArgumentOutOfRangeException,
        /// NotImplementedException for an interface that the connector has not, VciException where somebody has it.
        /// </summary>
        IBalResource OpenSocket(byte portNumber, Type socketType);
    }

    /// <summary>One connector.</summary>
    public interface IBalResource : IDisposable
    {
        /// <summary>Its number on the board, from 0.</summary>
        byte BusPort { get; }

        VciBusType BusType { get; }

        /// <summary>"CAN-1", counted from 1 for each kind of bus.</summary>
        string BusName { get; }
    }

    /// <summary>The connectors of a board, number 0 first.</summary>
    public sealed class BalResourceCollection : ReadOnlyCollectionBase
    {
        public BalResourceCollection(IBalResource[] resources)
        {
            InnerList.AddRange(resources);
        }

        public IBalResource this[int index]
        {
            get { return (IBalResource)InnerList[index]; }
        }
    }
}
